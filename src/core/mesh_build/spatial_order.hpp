#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/vec3.hpp"

namespace pierce {

/// The indices of points in the order of the leaves of a k-d tree whose left halves are full. Every
/// run of 2^k points that begins at a multiple of 2^k lies in a box of its own, if it is not
/// shorter than `leaf`, a power of two. Ties, and points within a leaf, keep the caller's order. On
/// up to `threads` threads. The nearer to the result the order `start` is, the sooner it is found;
/// it may be empty.
std::vector<std::uint32_t> spatial_order(std::span<const Vec3f> points, std::uint32_t leaf = 1,
                                         std::uint32_t threads = 1,
                                         std::span<const std::uint32_t> start = {});

}  // namespace pierce
