#pragma once

#include <utility>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce {

/// All pairs of triangles, the smaller id first, that cross each other at other places than common
/// vertices, or lie folded onto each other along a common edge. Vertices at the same position count
/// as one; triangles without area are left out. Indices must be valid and the triangles' positions
/// finite.
std::vector<std::pair<std::uint32_t, std::uint32_t>> self_intersections(const MeshData& mesh);

}  // namespace pierce
