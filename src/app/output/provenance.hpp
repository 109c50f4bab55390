#pragma once

#include <nlohmann/json_fwd.hpp>

/// What results depend on beside their settings. Every result that a command writes has it.
namespace pierce::app {

/// Processor, number of threads and system; the GPU, if one can be used.
nlohmann::json machine_json();

/// The commit and the versions of what it is built with.
nlohmann::json versions_json();

}  // namespace pierce::app
