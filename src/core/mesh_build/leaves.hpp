#pragma once

#include <span>
#include <vector>

#include "core/mesh/leaf.hpp"
#include "pierce/mesh.hpp"

namespace pierce::bvh {

/// Leaves for trees over a surface: each triangle is in one. Triangles that share an edge go
/// together, those in the smallest boxes first; in order of their first triangles.
std::vector<Leaf> leaves_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles);

}  // namespace pierce::bvh
