#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenes/detect/method.hpp"

namespace pierce::app {

/// Which vertex is asked about: of one of two mesh files, or of one of two bodies in a frame of a
/// recording.
struct ExplainOptions {
    std::vector<std::filesystem::path> inputs;  ///< two meshes, or a recording's folder
    std::uint32_t vertex = 0;
    std::optional<std::string> of;       ///< meshes: whose vertex, "a" (if not given) or "b"
    std::optional<std::uint32_t> frame;  ///< recording
    std::vector<std::uint32_t> bodies;   ///< recording: whose vertex, and against which other body
    scenes::RaySettings rays = {};
    std::filesystem::path json;  ///< empty: none
};

/// Why a vertex has, or has not, a contact with another body. Returns the process's exit code,
/// which is 0 for either.
int explain(const ExplainOptions& options);

}  // namespace pierce::app
