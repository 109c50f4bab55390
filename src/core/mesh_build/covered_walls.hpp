#pragma once

#include <span>
#include <vector>

#include "core/mesh/half_edges.hpp"
#include "core/mesh/surface.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Marks the walls within a closed surface as covered wholly: triangles between the same three
/// vertices, one of which faces one way for every one that faces the other, with the inside on both
/// sides. `sides`: of `triangles`; `covered`: per triangle, or empty, and then it is filled if
/// there are such walls.
void cover_walls(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                 const HalfEdges& sides, std::vector<Cover>& covered);

}  // namespace pierce
