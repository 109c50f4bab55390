#pragma once

#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/mesh_change.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Per triangle, the triangles across its three edges. `sides`: of all triangles.
std::vector<Neighbors> neighbors_of(std::size_t triangles, const HalfEdges& sides);

/// Per triangle, what is known about the surface around it; see TriangleRing. What `change` knows
/// is taken from it; it may be null.
std::vector<TriangleRing> rings_of(const MeshView& mesh, Workers& workers,
                                   const MeshChange* change = nullptr);

}  // namespace pierce
