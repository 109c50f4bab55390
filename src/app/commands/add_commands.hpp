#pragma once

#include <CLI/CLI.hpp>

namespace pierce::app {

/// Adds all commands. The one that runs sets `code`, the process's exit code.
void add_commands(CLI::App& app, int& code);

}  // namespace pierce::app
