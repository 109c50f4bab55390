#pragma once

#include <nanobind/nanobind.h>

namespace pierce::python {

namespace nb = nanobind;

/// Scenes, recordings, replays and validation.
void bind_recordings(nb::module_& module);

}  // namespace pierce::python
