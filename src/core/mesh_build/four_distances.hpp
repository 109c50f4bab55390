#pragma once

#include <limits>

#include "core/device/four.hpp"
#include "pierce/vec3.hpp"

/// How far a triangle is from four others, in float32: a lane each.
namespace pierce {

/// What is known of the distance of two triangles, relative to the extent of the two.
struct FourDistances {
    /// A distance that is wrong by less than this [extent] if the triangles do not pass through
    /// each other and none is a sliver: products are rounded by 2^-24 each, near-parallel edges are
    /// taken for parallel below an angle of `parallel`, and a normal is off by 2^-22 / `sliver`.
    static constexpr float error = 0x1p-9f;
    static constexpr float parallel = 0x1p-10f;
    static constexpr float sliver = 0x1p-8f;  ///< height over length
    static constexpr float too_near = 4;      ///< [error] the error would matter

    Four distance = 0;
    std::uint32_t unknown = 0;  ///< a bit for each that may pass through the triangle or is too
                                ///< near, or where a triangle is a sliver
};

/// Distances of one triangle from others. All are relative to a point near the first one.
class DistancesOfTriangle {
public:
    using Lanes = FourVec3[3];

    explicit DistancesOfTriangle(const Vec3f (&corner)[3])
        : own_{FourVec3::all(corner[0]), FourVec3::all(corner[1]), FourVec3::all(corner[2])} {}

    FourDistances from(const Lanes& other) const {
        Four extent_squared = 0;
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k)
                extent_squared = max_of(square(other[i] - own_[k]), extent_squared);
        Four least = std::numeric_limits<float>::infinity();
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 3; ++i)
                least = min_of(between_edges(own_[k], own_[after(k)], other[i], other[after(i)]),
                               least);
        FourDistances result;
        Four above = 0, below = 0;
        least = min_of(over_face(own_, other, least, above, below, result.unknown), least);
        const Four made_up = Four(FourDistances::error) * root_of(extent_squared);
        const Four limit = Four(0.5f) * root_of(least) - made_up;
        result.unknown |= ~greater(limit, min_of(above, below)) & Four::all_bits;
        least = min_of(over_face(other, own_, least, above, below, result.unknown), least);
        result.unknown |= ~greater(limit, min_of(above, below)) & Four::all_bits;
        result.distance = root_of(least) - made_up;
        result.unknown |= ~greater(result.distance, Four(FourDistances::too_near) * made_up) &
                          Four::all_bits;
        return result;
    }

private:
    static int after(int k) { return k == 2 ? 0 : k + 1; }
    static Four square(FourVec3 v) { return dot(v, v); }
    static Four root_of(Four x) {
        Four root = x;
        for (std::uint32_t k = 0; k < Four::count; ++k) root.set(k, std::sqrt(x[k]));
        return root;
    }
    /// NaN becomes 0.
    static Four clamped(Four x) { return min_of(max_of(x, 0), 1); }

    static Four from_end(FourVec3 p, FourVec3 a, FourVec3 way, Four squared) {
        return square(p - a - way * clamped(dot(p - a, way) / squared));
    }

    /// Squared. The segments are closest where their lines are, if both places lie on the segments;
    /// otherwise an end is closest (Ericson 2005, 5.1.9).
    static Four between_edges(FourVec3 a, FourVec3 b, FourVec3 c, FourVec3 d) {
        const FourVec3 u = b - a, v = d - c, w = a - c;
        const Four uu = square(u), vv = square(v), uv = dot(u, v), uw = dot(u, w), vw = dot(v, w);
        Four least = min_of(min_of(from_end(a, c, v, vv), from_end(b, c, v, vv)),
                            min_of(from_end(c, a, u, uu), from_end(d, a, u, uu)));
        const Four det = uu * vv - uv * uv, s = (uv * vw - vv * uw) / det,
                   t = (uu * vw - uv * uw) / det;
        const Four infinite = std::numeric_limits<float>::infinity(),
                   smallest = Four(FourDistances::parallel * FourDistances::parallel) * uu * vv;
        Four inner = square(w + u * s - v * t);
        inner = where(det, smallest, infinite, inner);
        inner = where(min_of(s, t), 0, infinite, inner);
        inner = where(1, max_of(s, t), infinite, inner);
        return min_of(inner, least);
    }

    /// The least squared height of corners over the face; `above` and `below`: how far the corners
    /// reach on each side of its plane. If an edge passes through the face although no corner and
    /// no border is nearer than the distance of the edges, the edge's ends are further than half
    /// of that from the plane: otherwise it would come nearer to the border, or end nearer to the
    /// face.
    static Four over_face(const Lanes& face, const Lanes& corner, Four least, Four& above,
                          Four& below, std::uint32_t& unknown) {
        const FourVec3 side = face[1] - face[0], other = face[2] - face[0],
                       normal = cross(side, other);
        const Four squared = square(normal),
                   longest = max_of(square(side), max_of(square(other), square(face[2] - face[1])));
        unknown |= ~greater(squared, Four(FourDistances::sliver * FourDistances::sliver) * longest *
                                         longest) &
                   Four::all_bits;
        const Four size = root_of(squared);
        above = below = 0;
        for (int k = 0; k < 3; ++k) {
            const Four height = dot(normal, corner[k] - face[0]) / size;
            above = max_of(height, above);
            below = max_of(-height, below);
            Four over = height * height;
            for (int i = 0; i < 3; ++i)
                over = where(dot(cross(normal, face[after(i)] - face[i]), corner[k] - face[i]), 0,
                             std::numeric_limits<float>::infinity(), over);
            least = min_of(over, least);
        }
        return least;
    }

    Lanes own_;
};

}  // namespace pierce
