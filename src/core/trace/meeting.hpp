#pragma once

#include "core/mesh/surface.hpp"
#include "core/trace/first_crossing.hpp"

namespace pierce {

/// How a ray meets the triangle its tracer found.
struct Meeting {
    double t = 0;  ///< [length] below zero for a place that is outside of the target and near it
    double barycentric[3] = {};
    bool exit = false;  ///< leaves the target, or touches its surface
    std::uint8_t padding[7] = {};
};

/// The meeting of a ray that leaves after `t` at point `p` of a triangle that is not degenerate.
/// Barycentrics follow from areas.
PIERCE_HD inline Meeting meeting_at(Vec3d p, double t, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d n = cross(b - a, c - a);
    const double area = length_squared(n);
    Meeting m;
    m.t = t;
    m.barycentric[0] = dot(n, cross(c - b, p - b)) / area;
    m.barycentric[1] = dot(n, cross(a - c, p - c)) / area;
    m.barycentric[2] = 1.0 - m.barycentric[0] - m.barycentric[1];
    m.exit = true;
    return m;
}

/// The meeting of a ray with a triangle it crosses, or lies in.
PIERCE_HD inline Meeting meeting_of(const Crossing& crossing, const Ray& ray, Vec3d a, Vec3d b,
                                    Vec3d c) {
    if (crossing.kind == Crossing::coplanar) return meeting_at(ray.origin, 0, a, b, c);
    Meeting m;
    m.t = crossing.t > ray.touch ? crossing.t : 0.0;
    for (int k = 0; k < 3; ++k) m.barycentric[k] = crossing.weight[k];
    m.exit = crossing.sign > 0;
    return m;
}

/// The meeting of a ray with a triangle of a surface, computed from the triangle itself, so that no
/// tracer's arithmetic reaches a result.
PIERCE_HD inline Meeting meet(const Ray& ray, const Surface& surface, std::uint32_t triangle) {
    const TriangleCorners at = surface.corners(triangle);
    return meeting_of(cross_triangle({ray.origin, ray.direction}, at.a, at.b, at.c), ray, at.a,
                      at.b, at.c);
}

}  // namespace pierce
