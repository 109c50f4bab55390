#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/half_edges.hpp"
#include "core/mesh/surface.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Two triangles between the same vertices that face each other: together they separate nothing.
using Twins = std::pair<std::uint32_t, std::uint32_t>;

/// The twins of a surface; each triangle has one at most. `sides`: of its triangles.
std::vector<Twins> twins_of(std::span<const Triangle> triangles, const HalfEdges& sides);

/// Marks the walls within a closed surface as covered wholly: twins with the inside on both sides.
/// `covered`: per triangle, or empty, and then it is filled if there are such walls.
void cover_walls(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                 std::span<const Twins> twins, std::vector<Cover>& covered);

}  // namespace pierce
