#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/vec3.hpp"

namespace pierce {

/// The indices of points in the order of the leaves of a k-d tree whose left halves are full. Every
/// run of 2^k points that begins at a multiple of 2^k lies in a box of its own. Ties keep the
/// caller's order. On up to `threads` threads.
std::vector<std::uint32_t> spatial_order(std::span<const Vec3d> points, std::uint32_t threads = 1);

}  // namespace pierce
