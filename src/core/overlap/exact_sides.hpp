#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "pierce/box.hpp"
#include "pierce/vec3.hpp"

/// On which side of what a point lies, without rounding. Two surfaces are put on a common grid
/// first; then every question has an integer for an answer. Where that is zero, the first surface
/// is taken to be moved along x by less than anything that can be told apart, along y by less than
/// that, and along z by less again. So all answers are those about one arrangement in which nothing
/// touches anything by chance (Edelsbrunner and Muecke 1990, here with three unknowns only).
namespace pierce {

/// Products of three differences of grid points fit in.
__extension__ using Wide = __int128;

/// Which of the two surfaces, the moved one or the other, a point or an edge is of.
enum class Shift : std::int8_t { moved = 1, other = -1 };

/// A point in whole steps from the middle of a grid.
using GridPoint = Vec3<std::int64_t>;

/// A grid as fine as Wide allows for a box.
class Grid {
public:
    explicit Grid(const Box& box) : origin_(box.center()), extent_(box.extent()) {
        // Differences then have less than 39 bits, and sums of six products of three less than 121.
        constexpr int bits = 37;
        step_ = std::exp2(std::ilogb(std::max(extent_, std::numeric_limits<double>::min())) + 1 -
                          bits);
    }
    GridPoint point(Vec3d p) const {
        const Vec3d steps = (1 / step_) * (p - origin_);
        return {std::llround(steps.x), std::llround(steps.y), std::llround(steps.z)};
    }
    /// From the middle of the grid.
    Vec3d place(GridPoint p) const {
        return step_ *
               Vec3d{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
    }
    Vec3d origin() const { return origin_; }
    /// [length] Of the box.
    double extent() const { return extent_; }
    /// [length] From one grid point to the next.
    double step() const { return step_; }

private:
    Vec3d origin_;
    double extent_, step_;
};

struct WideVector {
    Wide x, y, z;
};

inline WideVector wide_cross(GridPoint a, GridPoint b) {
    return {Wide{a.y} * b.z - Wide{a.z} * b.y, Wide{a.z} * b.x - Wide{a.x} * b.z,
            Wide{a.x} * b.y - Wide{a.y} * b.x};
}

inline Wide wide_dot(const WideVector& a, GridPoint b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// True if a number is positive, or, if it is zero, would be after the shift; `slope` is what it
/// changes by.
inline bool is_above(Wide value, const WideVector& slope, Shift shift) {
    if (value != 0) return value > 0;
    for (const Wide s : {slope.x, slope.y, slope.z})
        if (s != 0) return (s > 0) == (shift == Shift::moved);
    return false;
}

/// Where an edge goes through a triangle, if it does.
struct Piercing {
    int inward = 0;    ///< 1: to the side that the normal points away from, -1: to it; 0: not at
                       ///< all
    double along = 0;  ///< from `p` to `q`
};

/// Whether the edge from `p` to `q`, of the moved surface or the other one, goes through the
/// triangle `a`, `b`, `c` of the respective other one.
inline Piercing pierce_triangle(GridPoint p, GridPoint q, Shift edge, GridPoint a, GridPoint b,
                                GridPoint c) {
    const WideVector normal = wide_cross(b - a, c - a);
    const Wide at_p = wide_dot(normal, p - a), at_q = wide_dot(normal, q - a);
    const bool p_above = is_above(at_p, normal, edge), q_above = is_above(at_q, normal, edge);
    if (p_above == q_above) return {};
    const GridPoint way = q - p;
    const auto passes = [&](GridPoint r, GridPoint s) {
        const WideVector slope = wide_cross(way, s - r);
        // det(way, r - p, s - r) = -(way x (s - r)) . (r - p)
        return is_above(-wide_dot(slope, r - p), slope, edge);
    };
    const bool first = passes(a, b);
    if (passes(b, c) != first || passes(c, a) != first) return {};
    // Only one of the two can be zero, as they are on different sides.
    const auto height_p = static_cast<double>(at_p), height_q = static_cast<double>(at_q);
    return {p_above ? 1 : -1, height_p / (height_p - height_q)};
}

}  // namespace pierce
