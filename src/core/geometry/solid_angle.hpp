#pragma once

#include <cmath>

#include "core/geometry/float_rules.hpp"
#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// The solid angle under which a point sees a triangle (van Oosterom and Strackee 1983), whose
/// corners are given from the point on; positive from behind. Zero if the triangle lies in one
/// plane with the point.
PIERCE_HD inline double solid_angle(Vec3d a, Vec3d b, Vec3d c) {
    const double x = length(a), y = length(b), z = length(c), lengths = x * y * z,
                 volume = dot(a, cross(b, c));
    if (std::fabs(volume) <= constants::coplanar_tolerance * lengths) return 0;
    const double scale = lengths + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y,
                 angle = 2 * angle_of(scale, std::fabs(volume));
    return volume < 0 ? -angle : angle;
}

}  // namespace pierce
