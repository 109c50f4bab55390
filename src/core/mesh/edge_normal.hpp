#pragma once

#include "core/device/view.hpp"
#include "core/geometry/triangle_corners.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// The unit normal of a triangle; zero if it has no area.
PIERCE_HD inline Vec3d triangle_normal(const MeshView& mesh, View<const Vec3f> positions,
                                       std::uint32_t triangle) {
    return normalized(TriangleCorners(positions, mesh.triangles[triangle]).normal());
}

/// The unit outward normal of an edge: halfway between the normals of its triangles. So its
/// opposite leads inside between the triangles, whether they meet in a ridge or in a valley. Zero
/// where the normals cancel or the triangles have no area.
PIERCE_HD inline Vec3d edge_normal(const MeshView& mesh, View<const Vec3f> positions,
                                   const Edge& edge) {
    Vec3d sum = triangle_normal(mesh, positions, edge.triangle[0]);
    if (edge.triangle[1] != no_triangle) sum += triangle_normal(mesh, positions, edge.triangle[1]);
    return length(sum) > constants::vanishing_normal ? normalized(sum) : Vec3d{};
}

/// True if `direction`, leaving the edge, is strictly behind both of the edge's triangles; then
/// `direction` leads into the inside.
PIERCE_HD inline bool leads_inside(const MeshView& mesh, View<const Vec3f> positions,
                                   const Edge& edge, Vec3d direction) {
    if (edge.triangle[1] == no_triangle) return false;
    return dot(triangle_normal(mesh, positions, edge.triangle[0]), direction) < 0 &&
           dot(triangle_normal(mesh, positions, edge.triangle[1]), direction) < 0;
}

}  // namespace pierce
