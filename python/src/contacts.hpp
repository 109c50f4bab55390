#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>

#include "pierce/device_contacts.hpp"
#include "pierce/world.hpp"

namespace pierce::python {

namespace nb = nanobind;

/// The contacts of a step in Python. Arrays are views of the records, which stay as long as any of
/// them does.
struct Contacts {
    KeptContacts kept;
};

/// Contacts in device memory, and the world whose step wrote them.
struct DeviceList {
    DeviceContactList list;
    nb::object world;
};

void bind_contacts(nb::module_& module);

}  // namespace pierce::python
