#pragma once

#include <nanobind/nanobind.h>

namespace pierce::python {

namespace nb = nanobind;

/// Settings, what bodies are given, and what calls of a world answer.
void bind_results(nb::module_& module);

}  // namespace pierce::python
