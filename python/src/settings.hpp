#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <string>

#include "pierce/backend.hpp"
#include "pierce/settings.hpp"

/// What calls that make a world take.
namespace pierce::python {

namespace nb = nanobind;

/// Settings, or None for the defaults, with fields by name on top.
Settings settings_from(nb::handle settings, const nb::kwargs& fields);

/// The backend of a name: auto, embree, cuda, bvh or reference. `threads`: 0 is one per processor.
std::unique_ptr<Backend> backend_named(const std::string& name, int threads, int parts = 1,
                                       double host_share = 0);

}  // namespace pierce::python
