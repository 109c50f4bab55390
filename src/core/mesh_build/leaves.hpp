#pragma once

#include <span>
#include <vector>

#include "core/mesh/leaf.hpp"
#include "pierce/mesh.hpp"

namespace pierce::bvh {

/// Leaves for trees over a surface; each triangle is in one leaf. Triangles that share an edge are
/// coupled, those with the smallest common box first. Leaves are in the order of their first
/// triangles.
std::vector<Leaf> leaves_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles);

}  // namespace pierce::bvh
