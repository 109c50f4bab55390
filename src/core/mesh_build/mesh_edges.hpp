#pragma once

#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// The edges of a mesh, group after group (edge_group.hpp): those that are near each other are side
/// by side. Reads positions and triangles of `mesh`; `sides` are those of the triangles. It takes
/// less time if most edges are among those `before`, which may be null.
std::vector<Edge> edges_of(const MeshView& mesh, const HalfEdges& sides, Workers& workers,
                           const View<const Edge>* before = nullptr);

/// The features of every triangle; reads the edges of `mesh`.
std::vector<TriangleFeatures> features_of(const MeshView& mesh);

/// Every connected part of the surface, in the order of their first vertices.
std::vector<MeshPart> parts_of(const MeshView& mesh);

}  // namespace pierce
