#pragma once

#include <limits>

#include "pierce/host_device.hpp"
#include "pierce/min_max.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// An axis-aligned box; empty (lower above upper) by default.
struct Box {
    Vec3d lower{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                std::numeric_limits<double>::infinity()};
    Vec3d upper{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                -std::numeric_limits<double>::infinity()};

    PIERCE_HD void extend(Vec3d p) {
        lower = {min_of(p.x, lower.x), min_of(p.y, lower.y), min_of(p.z, lower.z)};
        upper = {max_of(p.x, upper.x), max_of(p.y, upper.y), max_of(p.z, upper.z)};
    }

    /// An empty box changes nothing.
    PIERCE_HD void extend(const Box& b) {
        lower = {min_of(b.lower.x, lower.x), min_of(b.lower.y, lower.y),
                 min_of(b.lower.z, lower.z)};
        upper = {max_of(b.upper.x, upper.x), max_of(b.upper.y, upper.y),
                 max_of(b.upper.z, upper.z)};
    }

    PIERCE_HD bool empty() const { return !(lower.x <= upper.x); }
    PIERCE_HD Vec3d center() const { return 0.5 * (lower + upper); }
    PIERCE_HD Vec3d half_size() const { return 0.5 * (upper - lower); }

    /// Length of the diagonal; the `extent` that relative tolerances multiply. Zero for an empty
    /// box.
    PIERCE_HD double extent() const { return empty() ? 0.0 : length(upper - lower); }

    /// The largest absolute coordinate of any point inside.
    PIERCE_HD double max_coordinate() const {
        double m = 0;
        for (int i = 0; i < 3; ++i) m = max_of(max_of(-lower[i], upper[i]), m);
        return m;
    }

    /// This box grown by `margin` on every side.
    PIERCE_HD Box inflated(double margin) const {
        const Vec3d m{margin, margin, margin};
        return {lower - m, upper + m};
    }

    /// True if `p` is inside or on the box.
    PIERCE_HD bool contains(Vec3d p) const {
        return p.x >= lower.x && p.x <= upper.x && p.y >= lower.y && p.y <= upper.y &&
               p.z >= lower.z && p.z <= upper.z;
    }

    /// Distance from `p` to the nearest point of the box; zero inside.
    PIERCE_HD double distance(Vec3d p) const {
        Vec3d gap;
        for (int i = 0; i < 3; ++i) gap[i] = max_of(max_of(lower[i] - p[i], p[i] - upper[i]), 0.0);
        return length(gap);
    }
};

/// The part of a line inside a box, in multiples of the line's direction; begin > end if the line
/// misses the box.
struct Stretch {
    double begin = -std::numeric_limits<double>::infinity(),
           end = std::numeric_limits<double>::infinity();
};

PIERCE_HD inline Stretch stretch_inside(const Box& box, Vec3d origin, Vec3d direction) {
    Stretch inside;
    for (int k = 0; k < 3; ++k) {
        if (direction[k] == 0) {
            if (origin[k] < box.lower[k] || origin[k] > box.upper[k]) return {1, 0};
            continue;
        }
        const double t0 = (box.lower[k] - origin[k]) / direction[k],
                     t1 = (box.upper[k] - origin[k]) / direction[k];
        inside.begin = max_of(min_of(t0, t1), inside.begin);
        inside.end = min_of(max_of(t0, t1), inside.end);
    }
    return inside;
}

/// True if the two closed boxes share a point; false as soon as a coordinate is NaN.
PIERCE_HD inline bool overlap(const Box& a, const Box& b) {
    return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x &&  //
           a.lower.y <= b.upper.y && b.lower.y <= a.upper.y &&  //
           a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

}  // namespace pierce
