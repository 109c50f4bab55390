#pragma once

#include "core/geometry/triangle.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/sheets/sheet_bounds.hpp"
#include "pierce/host_device.hpp"
#include "pierce/ids.hpp"

/// Edges that are through a triangle at the end of a step.
namespace pierce::stages {

/// True if a segment runs through a triangle, from one side to the other. Strictly: touching is not
/// piercing.
PIERCE_HD inline bool pierces(Vec3d p, Vec3d q, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d n = cross(b - a, c - a);
    const double from = dot(n, p - a), to = dot(n, q - a);
    if (!((from > 0 && to < 0) || (from < 0 && to > 0))) return false;
    const Vec3d d = q - p;
    const double u = dot(d, cross(a - p, b - p)), v = dot(d, cross(b - p, c - p)),
                 w = dot(d, cross(c - p, a - p));
    return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

/// True if a side of the triangle runs through one of the two triangles at the edge.
PIERCE_HD inline bool crosses_border(const SheetBody& of_edge, const Edge& edge,
                                     const SheetBody& of_face, std::uint32_t triangle) {
    const Vec3d origin = of_face.vertex(of_face.mesh.triangles[triangle].vertex[0]).end;
    const MovingTriangle face(of_face, triangle, origin);
    for (std::uint32_t side : edge.triangle) {
        if (side == no_triangle) continue;
        const MovingTriangle wing(of_edge, side, origin);
        for (int k = 0; k < 3; ++k)
            if (pierces(face.corner[k].end, face.corner[(k + 1) % 3].end, wing.corner[0].end,
                        wing.corner[1].end, wing.corner[2].end))
                return true;
    }
    return false;
}

/// Along which way of the edge the contour, in which its two triangles meet the other one, gets
/// shorter fastest. The edge runs through the other triangle at `at`, relative to `origin`, along
/// the unit vector `along`; `normal` is that triangle's.
PIERCE_HD inline Vec3d contour_gradient(const SheetBody& of_edge, const Edge& edge, Vec3d origin,
                                        Vec3d at, Vec3d along, Vec3d normal) {
    Vec3d gradient;
    for (std::uint32_t side : edge.triangle) {
        if (side == no_triangle) continue;
        const MovingTriangle wing(of_edge, side, origin);
        const Vec3d wing_normal = wing.end_normal();
        Vec3d contour = normalized(cross(normal, wing_normal));
        // The contour is to point into the wing, away from the edge.
        Vec3d middle;
        for (const MovingPoint& corner : wing.corner) middle += (1.0 / 3) * corner.end;
        if (dot(contour, middle - at - dot(middle - at, along) * along) < 0) contour = -contour;
        gradient += contour - (2 * dot(along, contour) / dot(along, normal)) * normal;
    }
    return gradient;
}

}  // namespace pierce::stages
