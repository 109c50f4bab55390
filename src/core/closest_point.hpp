#pragma once

#include "pierce/core/float_rules.hpp"
#include "pierce/core/vec3.hpp"

namespace pierce {

/// The point of the segment from `a` to `b` that is closest to `p`.
PIERCE_HD inline Vec3d closest_on_segment(Vec3d p, Vec3d a, Vec3d b) {
    const Vec3d ab = b - a;
    const double size = length_squared(ab);
    return size > 0 ? a + clamp_to(dot(p - a, ab) / size, 0.0, 1.0) * ab : a;
}

/// The point of a triangle that is closest to `p`; of its edges, if it has no area.
PIERCE_HD inline Vec3d closest_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d corner[3] = {a, b, c};
    const Vec3d n = cross(b - a, c - a);
    const double size = length_squared(n);
    bool above = size > 0;
    for (int k = 0; k < 3 && above; ++k) above = dot(cross(n, corner[(k + 1) % 3] - corner[k]), p - corner[k]) >= 0;
    if (above) return p - (dot(n, p - a) / size) * n;
    Vec3d best = closest_on_segment(p, a, b);
    for (int k = 1; k < 3; ++k) {
        const Vec3d other = closest_on_segment(p, corner[k], corner[(k + 1) % 3]);
        if (length_squared(p - other) < length_squared(p - best)) best = other;
    }
    return best;
}

}  // namespace pierce
