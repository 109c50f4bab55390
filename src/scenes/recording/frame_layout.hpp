#pragma once

#include <cstddef>
#include <cstdint>

#include "scenes/recording/recording.hpp"

/// Where the numbers of a body's frames are among all that are recorded of it.
namespace pierce::scenes {

inline constexpr std::size_t pose_size = 7;

/// The mesh of a body in a frame.
std::uint32_t mesh_of(const RecordedBody& body, std::uint32_t frame);

/// How many numbers there are for a body in a frame.
std::size_t frame_size(const Recording& recording, const RecordedBody& body, std::uint32_t frame);

/// Where a frame's numbers begin among those of a body.
std::size_t frame_begin(const Recording& recording, const RecordedBody& body, std::uint32_t frame);

}  // namespace pierce::scenes
