#pragma once

#include <nanobind/nanobind.h>

namespace pierce::python {

namespace nb = nanobind;

/// Pages that play what a world did.
void bind_pages(nb::module_& module);

}  // namespace pierce::python
