#pragma once

#include <algorithm>
#include <array>

#include "pierce/core/mesh.hpp"
#include "pierce/core/triangle.hpp"

namespace pierce {

/// Where a triangle's corners are.
using Corners = std::array<Vec3d, 3>;

inline Corners corners_of(View<const Vec3f> positions, const Triangle& t) {
    return {to_double(positions[t.vertex[0]]), to_double(positions[t.vertex[1]]), to_double(positions[t.vertex[2]])};
}

/// True if the triangles have a vertex id in common.
inline bool share_vertex(const Triangle& t, const Triangle& other) {
    return std::ranges::any_of(
        t.vertex, [&](std::uint32_t v) { return std::ranges::find(other.vertex, v) != std::end(other.vertex); });
}

/// True if an edge of `a` passes through `b`. Left aside are its ends, as far as `end_inset` [its length], and the border of
/// `b`, as far as `border_inset` [barycentric].
inline bool edge_pierces(const Corners& a, const Corners& b, double end_inset, double border_inset) {
    for (int k = 0; k < 3; ++k) {
        const Vec3d edge = a[(k + 1) % 3] - a[k];
        const double size = length(edge);
        if (!(size > 0)) continue;
        const Crossing crossing = cross_triangle({a[k], (1 / size) * edge}, b[0], b[1], b[2]);
        if (!crossing || crossing.t < end_inset * size || crossing.t > (1 - end_inset) * size) continue;
        if (std::ranges::all_of(crossing.weight, [&](double w) { return w >= border_inset; })) return true;
    }
    return false;
}

/// The sine of the angle between two triangles that share the edge from `a` to `b`, their third corners being `own` and
/// `other`; 1 from a right angle on, 0 where one lies folded onto the other.
inline double fold_sine(Vec3d a, Vec3d b, Vec3d own, Vec3d other) {
    const Vec3d edge = normalized(b - a);
    const auto across = [&](Vec3d p) {
        const Vec3d d = p - a;
        return normalized(d - dot(d, edge) * edge);
    };
    const Vec3d u = across(own), w = across(other);
    return dot(u, w) <= 0 ? 1 : length(cross(u, w));
}

}  // namespace pierce
