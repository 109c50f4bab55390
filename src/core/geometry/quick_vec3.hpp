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

/// What is left of a point that was rounded to `rounded`. GCC 12 takes the way to float32 and back
/// for no way at all where it vectorizes straight-line code (seen with -O2); it cannot see through
/// the empty statement.
PIERCE_HD inline Vec3d rest_of(Vec3d exact, Vec3f rounded) {
#if defined(__GNUC__) && !defined(__CUDA_ARCH__)
    asm("" : "+m"(rounded.x), "+m"(rounded.y), "+m"(rounded.z));
#endif
    return exact - to_double(rounded);
}

/// The largest absolute coordinate, and the sum of all absolute coordinates.
PIERCE_HD inline float largest_of(Vec3f v) {
    return quick_max(std::fabs(v.x), quick_max(std::fabs(v.y), std::fabs(v.z)));
}
PIERCE_HD inline float sum_of_sizes(Vec3f v) {
    return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z);
}

}  // namespace pierce
