#pragma once

#include "pierce/host_device.hpp"
#include "pierce/min_max.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// The point of the segment from `a` to `b` that is closest to `p`.
PIERCE_HD inline Vec3d closest_on_segment(Vec3d p, Vec3d a, Vec3d b) {
    const Vec3d ab = b - a;
    const double size = length_squared(ab);
    return size > 0 ? a + clamp_to(dot(p - a, ab) / size, 0.0, 1.0) * ab : a;
}

/// The point of a triangle that is closest to `p`; if the triangle has no area, the closest point
/// of its edges.
PIERCE_HD inline Vec3d closest_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d corner[3] = {a, b, c};
    const Vec3d n = cross(b - a, c - a);
    const double size = length_squared(n);
    bool above = size > 0;
    for (int k = 0; k < 3 && above; ++k)
        above = dot(cross(n, corner[(k + 1) % 3] - corner[k]), p - corner[k]) >= 0;
    if (above) return p - (dot(n, p - a) / size) * n;
    Vec3d best = closest_on_segment(p, a, b);
    for (int k = 1; k < 3; ++k) {
        const Vec3d other = closest_on_segment(p, corner[k], corner[(k + 1) % 3]);
        if (length_squared(p - other) < length_squared(p - best)) best = other;
    }
    return best;
}

/// Distance between two segments.
PIERCE_HD inline double segment_distance(Vec3d a, Vec3d b, Vec3d c, Vec3d d) {
    // The segments are closest where their lines are, if both places lie on the segments; otherwise
    // an end of a segment is closest (Ericson 2005, 5.1.9).
    double best = length(a - closest_on_segment(a, c, d));
    best = min_of(length(b - closest_on_segment(b, c, d)), best);
    best = min_of(length(c - closest_on_segment(c, a, b)), best);
    best = min_of(length(d - closest_on_segment(d, a, b)), best);
    const Vec3d u = b - a, v = d - c, w = a - c;
    const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w);
    const double det = uu * vv - uv * uv;
    if (!(det > 0)) return best;
    const double s = (uv * vw - vv * uw) / det, t = (uu * vw - uv * uw) / det;
    if (s < 0 || s > 1 || t < 0 || t > 1) return best;
    return min_of(length(w + s * u - t * v), best);
}

}  // namespace pierce
