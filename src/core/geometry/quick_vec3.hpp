#pragma once

#include "core/device/quick_math.hpp"
#include "pierce/vec3.hpp"

/// float32 arithmetic for bounds that hold however products are rounded: on a GPU a product and a
/// sum are one instruction, and its last bits differ from the host's. Nothing that a contact says
/// may come from here.
namespace pierce {

PIERCE_HD inline float quick_dot(Vec3f a, Vec3f b) {
    return quick_fma(a.x, b.x, quick_fma(a.y, b.y, a.z * b.z));
}

PIERCE_HD inline Vec3f quick_cross(Vec3f a, Vec3f b) {
    return {quick_fma(a.y, b.z, -(a.z * b.y)), quick_fma(a.z, b.x, -(a.x * b.z)),
            quick_fma(a.x, b.y, -(a.y * b.x))};
}

/// The largest size of a coordinate, and the sum of all.
PIERCE_HD inline float largest_of(Vec3f v) {
    return quick_max(std::fabs(v.x), quick_max(std::fabs(v.y), std::fabs(v.z)));
}
PIERCE_HD inline float sum_of_sizes(Vec3f v) {
    return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z);
}

}  // namespace pierce
