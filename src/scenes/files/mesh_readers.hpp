#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "pierce/mesh.hpp"

/// Readers of mesh files, from a file's content. They keep the order of vertices and triangles.
/// Each throws InputError, which says what is wrong and where.
namespace pierce::scenes {

/// Wavefront OBJ: `v` and `f`, with lines that go on after a backslash, and vertices that are
/// counted from the start or from the end. All else is passed over.
MeshData read_obj(std::string_view content);

/// PLY, as text or binary in either order of bytes: elements and properties in any order and of any
/// type; vertices have x, y and z, faces a list `vertex_indices` or `vertex_index`.
MeshData read_ply(std::string_view content);

/// STL, as text or binary. Corners at the same position are one vertex; triangles with two corners
/// at the same position are left out, as STL knows no vertices but by their positions.
MeshData read_stl(std::string_view content);

/// Object File Format as text, also with normals, colours and texture coordinates, which are passed
/// over. A number of edges need not be there.
MeshData read_off(std::string_view content);

/// Adds a polygon's fan of triangles; fewer than three corners have none.
inline void add_polygon(std::span<const std::uint32_t> corners, MeshData& mesh) {
    for (std::size_t k = 2; k < corners.size(); ++k)
        mesh.triangles.push_back({{corners[0], corners[k - 1], corners[k]}});
}

}  // namespace pierce::scenes
