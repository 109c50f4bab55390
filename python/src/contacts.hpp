#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <utility>

#include "pierce/device_contacts.hpp"
#include "pierce/world.hpp"

namespace pierce::python {

namespace nb = nanobind;

/// The contacts of a step in Python. Arrays are views of the records, which stay as long as any of
/// them does. Those of a step on a device come from there when somebody asks for them.
class Contacts {
public:
    explicit Contacts(KeptContacts kept) : kept_(std::move(kept)) {}
    /// Of the last step of a world on a device.
    Contacts(nb::object world, std::uint64_t step) : world_(std::move(world)), step_(step) {}

    /// Throws RuntimeError if they are on a device, where a later step has run.
    const KeptContacts& kept() const;

private:
    mutable KeptContacts kept_;
    mutable nb::object world_;  ///< until they have come
    std::uint64_t step_ = 0;
};

/// Contacts in device memory, and the world whose step wrote them.
struct DeviceList {
    DeviceContactList list;
    int device = 0;  ///< whose memory it is in
    std::uint32_t worlds = 0;
    nb::object world;
    std::uint64_t step = 0;  ///< of the world, after which the contacts are gone
};

void bind_contacts(nb::module_& module);

}  // namespace pierce::python
