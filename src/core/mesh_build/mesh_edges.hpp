#pragma once

#include <vector>

#include "core/mesh/mesh_view.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// The edges of a mesh, group after group (edge_group.hpp): those that are near each other are side
/// by side. Reads positions and triangles of `mesh`.
std::vector<Edge> edges_of(const MeshView& mesh);

/// The features of every triangle; reads the edges of `mesh`.
std::vector<TriangleFeatures> features_of(const MeshView& mesh);

/// One vertex of every connected part of the surface, in ascending order.
std::vector<std::uint32_t> parts_of(const MeshView& mesh);

}  // namespace pierce
