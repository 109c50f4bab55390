#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/ids.hpp"

namespace pierce::python {

namespace nb = nanobind;

/// Arrays in device memory that steps read, kept until the bodies get other places.
class KeptArrays {
public:
    /// `array` has the places of these bodies from now on; none: they have places of the host.
    void keep(std::span<const BodyId> bodies, nb::object array);

private:
    struct Slot {
        nb::object array;
        std::uint32_t bodies = 0;  ///< that are in it
    };
    std::vector<Slot> slots_;
    std::vector<std::uint32_t> slot_of_;  ///< per body, 0: none; else the slot after its number
};

}  // namespace pierce::python
