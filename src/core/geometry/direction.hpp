#pragma once

#include <algorithm>
#include <cmath>

#include "pierce/vec3.hpp"

namespace pierce {

/// The unit vector along a finite one, however long or short that is; the zero vector stays zero.
inline Vec3d unit_along(Vec3d v) {
    const double largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
    return largest > 0 ? normalized(Vec3d{v.x / largest, v.y / largest, v.z / largest}) : Vec3d{};
}

}  // namespace pierce
