#pragma once

#include <vector>

#include "core/mesh/mesh_view.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Per triangle, the triangles across its three edges.
std::vector<Neighbors> neighbors_of(std::span<const Triangle> triangles);

/// Per triangle, what is known about the surface around it; see TriangleRing.
std::vector<TriangleRing> rings_of(const MeshView& mesh);

}  // namespace pierce
