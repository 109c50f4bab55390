#pragma once

#include <vector>

#include "core/mesh/mesh_view.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// The edges of a mesh, patch after patch (patch.hpp): an edge belongs to the patch that holds the
/// first of its two vertices.
struct MeshEdges {
    std::vector<Edge> edges;
    std::vector<std::uint32_t> offsets;  ///< per patch and one more: where its edges begin
    std::vector<QuickBox> boxes;         ///< per patch, around its edges in the rest shape
};

/// Reads positions, triangles and patches of `mesh`.
MeshEdges edges_of(const MeshView& mesh);

/// The features of every triangle; reads the edges of `mesh`.
std::vector<TriangleFeatures> features_of(const MeshView& mesh);

/// One vertex of every connected part of the surface, in ascending order.
std::vector<std::uint32_t> parts_of(const MeshView& mesh);

}  // namespace pierce
