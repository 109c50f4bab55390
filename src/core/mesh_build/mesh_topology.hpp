#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh_view.hpp"

namespace pierce {

/// Of a mesh with valid indices and finite positions. `origin` is a point near it, which keeps the
/// volume accurate.
MeshTraits traits_of(const MeshData& data, Vec3d origin);

/// The corners of every vertex, in triangle order, and where each vertex's begin: vertex_count + 1
/// offsets.
std::pair<std::vector<std::uint32_t>, std::vector<Corner>> corners_of(
    std::span<const Triangle> triangles, std::size_t vertex_count);

/// Per corner, the vertices around each vertex, one after the other as its triangles hang together,
/// if those go around it once and none is left over; else no_vertex. A triangle at the vertex has
/// two of them that follow each other.
std::vector<std::uint32_t> fans_of(std::span<const std::uint32_t> corner_offsets,
                                   std::span<const Corner> corners);

}  // namespace pierce
