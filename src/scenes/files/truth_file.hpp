#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "pierce/vec3.hpp"

namespace pierce::scenes {

/// A vertex that is truly inside another body, and the way to the closest point of that body's
/// surface.
struct TrueVertex {
    std::uint32_t source = 0, target = 0;  ///< bodies by their index in the recording
    std::uint32_t vertex = 0;
    double depth = 0;  ///< [length]
    Vec3d way_out;     ///< unit, world space
};

/// What every method should find in a frame.
struct TrueFrame {
    std::uint32_t frame = 0;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> overlapping;  ///< sorted, lower body first
    std::vector<TrueVertex> inside;  ///< by source, target, vertex
};

/// Reads what pierce_truth wrote about a recording. Throws InputError, naming the file, for any
/// other content.
std::vector<TrueFrame> read_truth(const std::filesystem::path& file);

}  // namespace pierce::scenes
