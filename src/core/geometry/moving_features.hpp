#pragma once

#include "core/geometry/closest_place_on_triangle.hpp"
#include "core/geometry/moving_point.hpp"
#include "core/geometry/separating_direction.hpp"
#include "pierce/min_max.hpp"

/// Two convex features whose four corners move: where the features are closest at a time, and
/// halves of one feature.
namespace pierce::continuous {

using separating::Corners;

/// A place on both features.
struct Place {
    double u = 0, v = 0;
};

/// A vertex and a part of a face.
struct VertexAndFace {
    static constexpr int firsts = 1;

    double u[3] = {0, 1, 0}, v[3] = {0, 0, 1};  ///< weights of the part's corners
    double width = 1;

    PIERCE_HD Corners part(const Corners& whole) const {
        const Vec3d a = whole.at[1], ab = whole.at[2] - a, ac = whole.at[3] - a;
        Corners c{{whole.at[0]}};
        for (int k = 0; k < 3; ++k) c.at[k + 1] = a + u[k] * ab + v[k] * ac;
        return c;
    }

    /// The closest place, within the part.
    PIERCE_HD static Place closest(const Corners& c) {
        const TrianglePlace place = closest_place_on_triangle(c.at[0], c.at[1], c.at[2], c.at[3]);
        return {place.second, place.third};
    }

    PIERCE_HD static Vec3d difference(const Corners& c, Place p) {
        return c.at[0] - c.at[1] - p.u * (c.at[2] - c.at[1]) - p.v * (c.at[3] - c.at[1]);
    }

    PIERCE_HD Place in_whole(Place p) const {
        const double w = max_of(1 - p.u - p.v, 0.0);
        return {w * u[0] + p.u * u[1] + p.v * u[2], w * v[0] + p.u * v[1] + p.v * v[2]};
    }

    /// Keeps the half with the place and returns the other half; it halves the edge that is longest
    /// over both times.
    PIERCE_HD VertexAndFace halve(const Corners& now, const Corners& end, Place p) {
        int longest = 0;
        double most = -1;
        for (int k = 0; k < 3; ++k) {
            const int next = k == 2 ? 0 : k + 1;
            const double length = length_squared(now.at[next + 1] - now.at[k + 1]) +
                                  length_squared(end.at[next + 1] - end.at[k + 1]);
            if (!(length > most)) continue;
            most = length;
            longest = k;
        }
        const int next = longest == 2 ? 0 : longest + 1;
        const double weight[3] = {1 - p.u - p.v, p.u, p.v};
        const bool nearer_next = weight[next] > weight[longest];
        const double middle_u = 0.5 * (u[longest] + u[next]),
                     middle_v = 0.5 * (v[longest] + v[next]);
        width *= 0.7071067811865476;
        VertexAndFace other = *this;
        const int moved = nearer_next ? longest : next, kept = nearer_next ? next : longest;
        u[moved] = middle_u;
        v[moved] = middle_v;
        other.u[kept] = middle_u;
        other.v[kept] = middle_v;
        return other;
    }
};

/// Parts of two edges.
struct TwoEdges {
    static constexpr int firsts = 2;

    double u[2] = {0, 1}, v[2] = {0, 1};  ///< places of the parts' ends along the edges
    double width = 1;

    PIERCE_HD Corners part(const Corners& whole) const {
        const Vec3d a = whole.at[0], along_a = whole.at[1] - a, b = whole.at[2],
                    along_b = whole.at[3] - b;
        return {{a + u[0] * along_a, a + u[1] * along_a, b + v[0] * along_b, b + v[1] * along_b}};
    }

    PIERCE_HD static Place closest(const Corners& c) {
        const SegmentPlaces places = closest_points_of_segments(c.at[0], c.at[1], c.at[2], c.at[3]);
        return {places.first, places.second};
    }

    PIERCE_HD static Vec3d difference(const Corners& c, Place p) {
        return c.at[0] + p.u * (c.at[1] - c.at[0]) - c.at[2] - p.v * (c.at[3] - c.at[2]);
    }

    PIERCE_HD Place in_whole(Place p) const {
        return {u[0] + p.u * (u[1] - u[0]), v[0] + p.v * (v[1] - v[0])};
    }

    PIERCE_HD TwoEdges halve(const Corners& now, const Corners& end, Place p) {
        const double first = length_squared(now.at[1] - now.at[0]) +
                             length_squared(end.at[1] - end.at[0]);
        const double second = length_squared(now.at[3] - now.at[2]) +
                              length_squared(end.at[3] - end.at[2]);
        width *= 0.7071067811865476;
        TwoEdges other = *this;
        const bool at_first = first > second;
        double* const mine = at_first ? u : v;
        double* const others = at_first ? other.u : other.v;
        const int moved = (at_first ? p.u : p.v) > 0.5 ? 0 : 1;
        mine[moved] = others[1 - moved] = 0.5 * (mine[0] + mine[1]);
        return other;
    }
};

/// Corners relative to the first one, which then stands still. Differences are exact or rounded
/// once, however far from the origin the corners are. A movement that all corners share drops out.
PIERCE_HD inline void relative_corners(const MovingPoint& p, const MovingPoint& q,
                                       const MovingPoint& r, const MovingPoint& s, Corners& start,
                                       Corners& end) {
    start = {{{}, q.start - p.start, r.start - p.start, s.start - p.start}};
    end = {{{}, q.end - p.end, r.end - p.end, s.end - p.end}};
}

}  // namespace pierce::continuous
