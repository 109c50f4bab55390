#pragma once

#include "core/mesh/surface.hpp"
#include "pierce/min_max.hpp"

/// How far a segment is from a triangle at least.
namespace pierce::stages {

/// A lower bound of the distance between the segment from `a` to `b` and a triangle of a surface
/// [length], or `limit` if it is certainly no less; zero only if they meet, nearly meet, or lie in
/// one plane. It looks along the directions that separate a segment and a triangle (Gottschalk, Lin
/// and Manocha 1996): the triangle's normal, and the products of its sides with the segment; and
/// across each side in the triangle's plane.
PIERCE_HD inline double segment_gap(Vec3d a, Vec3d b, const Surface& surface,
                                    std::uint32_t triangle, double limit) {
    const Triangle& t = surface.triangles[triangle];
    const Vec3d v0 = to_double(surface.positions[t.vertex[0]]),
                v1 = to_double(surface.positions[t.vertex[1]]),
                v2 = to_double(surface.positions[t.vertex[2]]);
    double squared = 0;
    // `gap`: how far they are apart along a direction, times its length. True if that is enough.
    const auto is_enough = [&](Vec3d along, double gap) {
        if (!(gap > 0)) return false;
        const double size = length_squared(along);
        if (gap * gap >= limit * limit * size) return true;
        squared = max_of(gap * gap / size, squared);
        return false;
    };
    const Vec3d way = b - a, normal = cross(v1 - v0, v2 - v0);
    const double above = dot(normal, a - v0), beyond = dot(normal, b - v0);
    if (is_enough(normal, max_of(min_of(above, beyond), -max_of(above, beyond)))) return limit;
    const auto is_enough_at_side = [&](Vec3d from, Vec3d to, Vec3d opposite) {
        const Vec3d across = cross(way, to - from);
        const double side = dot(across, from - a), corner = dot(across, opposite - a);
        if (is_enough(across, max_of(min_of(side, corner), -max_of(side, corner)))) return true;
        const Vec3d outward = cross(to - from, normal);
        return is_enough(outward, min_of(dot(outward, a - from), dot(outward, b - from)));
    };
    if (is_enough_at_side(v0, v1, v2) || is_enough_at_side(v1, v2, v0) ||
        is_enough_at_side(v2, v0, v1))
        return limit;
    return std::sqrt(squared);
}

}  // namespace pierce::stages
