#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/device/view.hpp"
#include "core/geometry/triangle.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Where a triangle's corners are.
using Corners = std::array<Vec3d, 3>;

inline Corners corners_of(View<const Vec3f> positions, const Triangle& t) {
    return {to_double(positions[t.vertex[0]]), to_double(positions[t.vertex[1]]),
            to_double(positions[t.vertex[2]])};
}

/// True if the triangles have a vertex id in common.
inline bool share_vertex(const Triangle& t, const Triangle& other) {
    bool shares = false;
    for (const std::uint32_t v : t.vertex)
        shares |= v == other.vertex[0] || v == other.vertex[1] || v == other.vertex[2];
    return shares;
}

/// True if the segment from `p` to `q` passes through `b`. Its ends up to `end_inset` [its length]
/// and the border of `b` up to `border_inset` [barycentric] do not count.
inline bool segment_pierces(Vec3d p, Vec3d q, const Corners& b, double end_inset,
                            double border_inset) {
    const Vec3d edge = q - p;
    const double size = length(edge);
    if (!(size > 0)) return false;
    const Crossing crossing = cross_triangle({p, (1 / size) * edge}, b[0], b[1], b[2]);
    if (!crossing || crossing.t < end_inset * size || crossing.t > (1 - end_inset) * size)
        return false;
    return std::ranges::all_of(crossing.weight, [&](double w) { return w >= border_inset; });
}

/// True if an edge of `a` passes through `b`, as segment_pierces() has it.
inline bool edge_pierces(const Corners& a, const Corners& b, double end_inset,
                         double border_inset) {
    for (std::size_t k = 0; k < 3; ++k)
        if (segment_pierces(a[k], a[(k + 1) % 3], b, end_inset, border_inset)) return true;
    return false;
}

/// The sine of the angle between two triangles that share the edge from `a` to `b`; their third
/// corners are `own` and `other`. It is 1 from a right angle on, and 0 where one triangle lies
/// folded onto the other.
inline double fold_sine(Vec3d a, Vec3d b, Vec3d own, Vec3d other) {
    const Vec3d edge = normalized(b - a);
    const auto across = [&](Vec3d p) {
        const Vec3d d = p - a;
        return normalized(d - dot(d, edge) * edge);
    };
    const Vec3d u = across(own), w = across(other);
    return dot(u, w) <= 0 ? 1 : length(cross(u, w));
}

/// True if the triangles pass through each other: each has corners on both sides of the other's
/// plane, and the segments in which they meet the line common to both planes overlap (Moeller
/// 1997). A touch that goes no deeper than constants::touch_tolerance times the two triangles'
/// extent does not count.
inline bool triangles_cross(const Corners& a, const Corners& b) {
    Box box;
    for (Vec3d p : a) box.extend(p);
    for (Vec3d p : b) box.extend(p);
    const double touch = constants::touch_tolerance * box.extent();
    const Vec3d normal_a = normalized(cross(a[1] - a[0], a[2] - a[0]));
    const Vec3d normal_b = normalized(cross(b[1] - b[0], b[2] - b[0]));
    const Vec3d line = normalized(cross(normal_a, normal_b));

    // The range along the line where a triangle meets a plane; empty if the triangle lies on one
    // side.
    const auto segment = [&](const Corners& c, Vec3d on_plane, Vec3d normal) {
        double side[3];
        for (int k = 0; k < 3; ++k) side[k] = dot(normal, c[k] - on_plane);
        std::pair<double, double> range(INFINITY, -INFINITY);
        if (!(*std::ranges::min_element(side) < -touch && *std::ranges::max_element(side) > touch))
            return range;
        for (int k = 0; k < 3; ++k) {
            const int next = (k + 1) % 3;
            if ((side[k] < 0) == (side[next] < 0)) continue;
            const Vec3d p = c[k] + (side[k] / (side[k] - side[next])) * (c[next] - c[k]);
            const double at = dot(line, p - a[0]);
            range = {std::min(range.first, at), std::max(range.second, at)};
        }
        return range;
    };
    const auto in_a = segment(a, b[0], normal_b), in_b = segment(b, a[0], normal_a);
    return std::min(in_a.second, in_b.second) - std::max(in_a.first, in_b.first) > touch;
}

}  // namespace pierce
