#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"

namespace pierce {

/// Throws InputError for a mesh that is refused (Mesh).
void check_mesh_data(const std::string& name, const MeshData& data);

/// The traits of a mesh with valid indices and finite positions. `sides`: of its triangles;
/// `origin`: a point near the mesh, which keeps the volume accurate.
MeshTraits traits_of(const MeshData& data, const HalfEdges& sides, Vec3d origin);

/// The corners of every vertex, in triangle order, and where the corners of each vertex begin:
/// vertex_count + 1 offsets.
std::pair<std::vector<std::uint32_t>, std::vector<Corner>> corners_by_vertex(
    std::span<const Triangle> triangles, std::size_t vertex_count);

/// Per corner, the vertices around each vertex in the order in which its triangles are connected.
/// The entries are no_vertex unless the triangles go around the vertex once and none is left over.
/// The other two vertices of a triangle at the vertex follow each other.
std::vector<std::uint32_t> fans_of(std::span<const std::uint32_t> corner_offsets,
                                   std::span<const Corner> corners);

}  // namespace pierce
