#pragma once

#include <CLI/CLI.hpp>

namespace pierce::app {

/// Makes all commands refuse options that other ones, or the scene, leave without effect, and names
/// of files that are empty.
void refuse_what_has_no_effect(CLI::App& app);

}  // namespace pierce::app
