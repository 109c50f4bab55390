#pragma once

#include <algorithm>
#include <limits>

#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// [length] By how much a ray starts before a box that begins `begin` ahead: a surface in the box's
/// face still lies ahead then, and from far away, the way there is rounded.
inline double start_before(double begin, double touch) {
    return 2 * touch + constants::double_rounding * std::max(begin, 0.0);
}

/// [length] How far along a line a ray may start that is to meet what is in a box: just outside of
/// the box, or 0 within it. Far away from a body, rounding would take its triangles for seen from
/// the side. Infinite if the line does not meet the box ahead.
inline double start_near(const Box& box, Vec3d origin, Vec3d direction, double touch) {
    const Stretch inside = stretch_inside(box, origin, direction);
    if (inside.begin > inside.end || inside.end < 0) return std::numeric_limits<double>::infinity();
    return std::max(inside.begin - start_before(inside.begin, touch), 0.0);
}

}  // namespace pierce
