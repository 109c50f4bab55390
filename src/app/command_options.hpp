#pragma once

#include <CLI/CLI.hpp>

#include "app/commands.hpp"

namespace pierce::app {

/// Refuses what is no positive, finite number.
extern const CLI::Validator positive_number;

/// What is looked for, and where contacts end.
void add_coverage(CLI::App& command, Settings& settings);
void add_temporal(CLI::App& command, Settings& settings);
/// Backend, threads, coverage and memory.
void add_rays(CLI::App& command, scenes::RaySettings& rays);
void add_detection(CLI::App& command, DetectionOptions& options);
/// The scene, and how large it is.
void add_scene(CLI::App& command, RunOptions& options);

}  // namespace pierce::app
