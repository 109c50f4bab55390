#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/geometry/triangle_pair.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"

/// How far a triangle's neighbours open away from it.
namespace pierce {

/// All between two directions from a point.
struct Wedge {
    Vec3d side[2];  ///< unit
    Vec3d normal;
    Vec3d inward[2];  ///< at right angles to each side, in the wedge's plane

    explicit Wedge(const Corners& c)
        : side{normalized(c[1] - c[0]), normalized(c[2] - c[0])},
          normal(cross(side[0], side[1])),
          inward{cross(normal, side[0]), cross(side[1], normal)} {}

    double squared_distance(Vec3d unit) const {
        double least = 1;
        for (const Vec3d way : side) {
            const double along = dot(unit, way);
            if (along > 0) least = std::min(length_squared(unit - along * way), least);
        }
        const double size = length_squared(normal), height = dot(unit, normal);
        if (size > 0 && dot(unit, inward[0]) >= 0 && dot(unit, inward[1]) >= 0)
            least = std::min(height * height / size, least);
        return least;
    }
    /// True if the other wedge is certainly on one side of this one's plane.
    bool leaves_aside(const Wedge& other) const {
        const double first = dot(normal, other.side[0]), second = dot(normal, other.side[1]);
        return std::min(first, second) > constants::touch_tolerance ||
               std::max(first, second) < -constants::touch_tolerance;
    }
};

/// The corners of a triangle from corner `k` on.
inline Corners from_corner(const Corners& c, std::size_t k) {
    return {c[k], c[(k + 1) % 3], c[(k + 2) % 3]};
}

/// True if triangles that share their first corner pass through each other: the side of one of them
/// that lies opposite the corner passes through the other one.
inline bool cross_beyond_corner(const Corners& own, const Corners& other) {
    constexpr double inset = constants::touch_tolerance;
    return segment_pierces(own[1], own[2], other, inset, inset) ||
           segment_pierces(other[1], other[2], own, inset, inset);
}

/// The openness between a triangle and others that share vertices with it: no point of the other
/// one is closer to a point Q of this one than this times Q's distance to this one's border. At a
/// shared edge, the other triangle lies in a half plane. Its distance from Q is Q's distance to the
/// edge, or that times the sine of the dihedral angle. At a shared vertex, each triangle lies in a
/// wedge. The openness is the distance of unit vectors along the sides of one wedge from the other
/// wedge. It is 0 where the triangles pass through each other.
class Openness {
public:
    explicit Openness(const Corners& own)
        : own_(own), wedges_{Wedge(own), Wedge(from_corner(own, 1)), Wedge(from_corner(own, 2))} {}

    double towards(const Triangle& own, const Triangle& other, const Corners& corners) const {
        std::size_t shared = 0, mine = 0, its = 0, my_rest = 0;
        for (std::size_t k = 0; k < 3; ++k)
            if (has_vertex(other, own.vertex[k])) {
                mine = k;
                its = static_cast<std::size_t>(corner_of(other, own.vertex[k]));
                ++shared;
            } else {
                my_rest = k;
            }
        if (shared == 1) return at_corner(mine, from_corner(corners, its));
        if (shared != 2) return 0;
        const Corners c = from_corner(own_, my_rest);
        for (std::size_t k = 0; k < 3; ++k)
            if (!has_vertex(own, other.vertex[k])) return fold_sine(c[1], c[2], c[0], corners[k]);
        return 0;
    }

private:
    double at_corner(std::size_t corner, const Corners& its) const {
        const Wedge &own = wedges_[corner], other(its);
        if (!own.leaves_aside(other) && !other.leaves_aside(own) &&
            cross_beyond_corner(from_corner(own_, corner), its))
            return 0;
        double least = 1;
        for (const Vec3d unit : own.side) least = std::min(other.squared_distance(unit), least);
        for (const Vec3d unit : other.side) least = std::min(own.squared_distance(unit), least);
        return std::sqrt(least);
    }

    Corners own_;
    Wedge wedges_[3];
};

}  // namespace pierce
