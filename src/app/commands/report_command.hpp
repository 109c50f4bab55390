#pragma once

#include <CLI/CLI.hpp>

namespace pierce::app {

/// Adds the command `report`, which sets `code`, the process's exit code, when it has run.
void add_report(CLI::App& app, int& code);

}  // namespace pierce::app
