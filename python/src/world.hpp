#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>

#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pierce/world.hpp"

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

/// A World in Python. One thread uses it at a time.
struct PyWorld {
    std::shared_ptr<World> world;
    bool on_device = false;
    std::uint64_t steps = 0;  ///< that Python has run
    std::mutex busy;
    KeptArrays places, starts;
    nb::object stream;           ///< kept while steps wait for it
    nb::object filter;           ///< of pairs; the world calls it
    std::exception_ptr failure;  ///< of the filter, in the last step

    /// Asks the filter; what it throws is kept until the step is over, and the pair is left out.
    bool wants(BodyId a, BodyId b);

    PyWorld(std::shared_ptr<World> its_world, bool runs_on_device)
        : world(std::move(its_world)), on_device(runs_on_device) {}
};

/// The use of a world by one thread. Throws RuntimeError if another thread uses it.
class Use {
public:
    explicit Use(PyWorld& of) : lock_(of.busy, std::try_to_lock), world_(of.world.get()) {
        if (!lock_.owns_lock())
            throw std::runtime_error(
                "this World is in a call of another thread, or of its own pair filter");
    }
    World* operator->() const { return world_; }
    World& operator*() const { return *world_; }

private:
    std::unique_lock<std::mutex> lock_;
    World* world_;
};

/// Runs a step without the interpreter's lock, and returns its contacts.
nb::object detect(nb::handle_t<PyWorld> self);

void bind_world(nb::module_& module);

}  // namespace pierce::python
