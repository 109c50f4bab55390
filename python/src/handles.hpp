#pragma once

#include <nanobind/nanobind.h>

namespace pierce::python {

namespace nb = nanobind;

/// Handles of bodies and meshes.
void bind_handles(nb::module_& module);

}  // namespace pierce::python
