#pragma once

#include <CLI/CLI.hpp>

namespace pierce::app {

/// Makes all commands refuse options that other ones, or the scene, leave without effect, names of
/// files that are empty, and outputs that would replace what is read.
void refuse_what_has_no_effect(CLI::App& app);

}  // namespace pierce::app
