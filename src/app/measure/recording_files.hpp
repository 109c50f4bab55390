#pragma once

#include <filesystem>

#include "scenes/recording/recording.hpp"

/// Recordings on disk, with bars that show how far they are.
namespace pierce::app {

/// As scenes::read_recording().
scenes::Recording load_recording(const std::filesystem::path& folder);

/// As scenes::write_recording().
void save_recording(const scenes::Recording& recording, const std::filesystem::path& folder);

}  // namespace pierce::app
