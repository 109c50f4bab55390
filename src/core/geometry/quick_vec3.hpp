#pragma once

#include "core/device/quick_math.hpp"
#include "pierce/vec3.hpp"

/// float32 arithmetic for bounds that hold however products are rounded: a GPU computes a product
/// and a sum in one instruction, and its last bits differ from the host's. No value of a contact
/// may come from this arithmetic.
namespace pierce {

PIERCE_HD inline float quick_dot(Vec3f a, Vec3f b) {
    return quick_fma(a.x, b.x, quick_fma(a.y, b.y, a.z * b.z));
}

PIERCE_HD inline Vec3f quick_cross(Vec3f a, Vec3f b) {
    return {quick_fma(a.y, b.z, -(a.z * b.y)), quick_fma(a.z, b.x, -(a.x * b.z)),
            quick_fma(a.x, b.y, -(a.y * b.x))};
}

/// The largest absolute coordinate, and the sum of all absolute coordinates.
PIERCE_HD inline float largest_of(Vec3f v) {
    return quick_max(std::fabs(v.x), quick_max(std::fabs(v.y), std::fabs(v.z)));
}
PIERCE_HD inline float sum_of_sizes(Vec3f v) {
    return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z);
}

}  // namespace pierce
