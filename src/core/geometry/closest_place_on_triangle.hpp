#pragma once

#include "core/geometry/closest_points_of_segments.hpp"

namespace pierce {

/// A point of a triangle: the weights of its second and third corner; the weight of the first is 1
/// minus both.
struct TrianglePlace {
    double second = 0, third = 0;
};

/// Where a triangle is closest to `p`. The place lies in the triangle, even if that has no area.
PIERCE_HD inline TrianglePlace closest_place_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d ab = b - a, ac = c - a, ap = p - a, n = cross(ab, ac);
    const double size = length_squared(n);
    double weight[3] = {-1, -1, -1};
    if (size > 0) {
        weight[1] = dot(cross(ap, ac), n) / size;
        weight[2] = dot(cross(ab, ap), n) / size;
        weight[0] = 1 - weight[1] - weight[2];
        if (weight[0] >= 0 && weight[1] >= 0 && weight[2] >= 0) return {weight[1], weight[2]};
    }
    // If `p` is on the inner side of an edge's line, another part of the triangle is closer than
    // that edge.
    TrianglePlace best;
    double closest = length_squared(ap);
    const auto offer = [&](TrianglePlace place) {
        const double distance = length_squared(ap - place.second * ab - place.third * ac);
        if (!(distance < closest)) return;
        closest = distance;
        best = place;
    };
    if (!(weight[2] >= 0)) offer({closest_place_on_segment(p, a, ab), 0});
    if (!(weight[1] >= 0)) offer({0, closest_place_on_segment(p, a, ac)});
    if (!(weight[0] >= 0)) {
        const double place = closest_place_on_segment(p, b, c - b);
        offer({1 - place, place});
    }
    return best;
}

}  // namespace pierce
