#pragma once

#include "core/device/view.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

PIERCE_HD inline bool has_triangles(const MeshView& mesh, std::uint32_t v) {
    return mesh.corner_offsets[v] < mesh.corner_offsets[v + 1];
}

/// The unit outward normal of vertex `v`: its triangles' normals weighted by their angle at `v`,
/// which makes its sign right for inside tests (Baerentzen and Aanaes 2005). Zero if the triangles
/// cancel or have no area.
PIERCE_HD inline Vec3d vertex_normal(const MeshView& mesh, View<const Vec3f> positions,
                                     std::uint32_t v) {
    const Vec3d apex = to_double(positions[v]);
    Vec3d sum;
    double angles = 0;
    for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i) {
        const Vec3d a = to_double(positions[mesh.corners[i].next]) - apex;
        const Vec3d b = to_double(positions[mesh.corners[i].previous]) - apex;
        const Vec3d n = cross(a, b);
        const double sine = length(n);
        if (!(sine > 0)) continue;
        const double angle = angle_of(dot(a, b), sine);
        sum += (angle / sine) * n;
        angles += angle;
    }
    return length(sum) > constants::vanishing_normal * angles ? normalized(sum) : Vec3d{};
}

/// True if `direction`, leaving vertex `v`, is strictly behind every triangle around it. Then
/// `direction` leads into the inside of a closed surface. Seen from `v`, the inside is a spherical
/// polygon. If the direction were outside of that polygon, the polygon's nearest point would lie on
/// an edge or a corner, and a triangle there would have the direction in front.
PIERCE_HD inline bool leads_inside(const MeshView& mesh, View<const Vec3f> positions,
                                   std::uint32_t v, Vec3d direction) {
    const Vec3d apex = to_double(positions[v]);
    for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i) {
        const Vec3d a = to_double(positions[mesh.corners[i].next]) - apex;
        const Vec3d b = to_double(positions[mesh.corners[i].previous]) - apex;
        if (!(dot(cross(a, b), direction) < 0)) return false;
    }
    return true;
}

/// True if `direction`, unit, is behind every triangle around vertex `v` by more than rounding:
/// constants::touch_tolerance is the sine. Triangles without area have no side.
PIERCE_HD inline bool leads_well_inside(const MeshView& mesh, View<const Vec3f> positions,
                                        std::uint32_t v, Vec3d direction) {
    const Vec3d apex = to_double(positions[v]);
    for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i) {
        const Vec3d a = to_double(positions[mesh.corners[i].next]);
        const Vec3d b = to_double(positions[mesh.corners[i].previous]);
        if (is_degenerate(apex, a, b)) continue;
        const Vec3d normal = normalized(cross(a - apex, b - apex));
        if (!(dot(normal, direction) < -constants::touch_tolerance)) return false;
    }
    return true;
}

}  // namespace pierce
