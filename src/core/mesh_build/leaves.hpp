#pragma once

#include <span>
#include <vector>

#include "core/mesh/half_edges.hpp"
#include "core/mesh/leaf.hpp"
#include "pierce/mesh.hpp"

namespace pierce::bvh {

/// Leaves for trees over a surface; each triangle is in one leaf. Triangles that share an edge are
/// coupled, those with the smallest common box first. Leaves are in the order of their first
/// triangles. `sides`: of all triangles. `partner`: per triangle, the one that it is coupled with
/// in any case, or no_triangle; may be empty.
std::vector<Leaf> leaves_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                            const HalfEdges& sides, std::span<const std::uint32_t> partner = {});
std::vector<Leaf> leaves_of(const MeshData& mesh);

}  // namespace pierce::bvh
