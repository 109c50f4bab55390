#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "pierce/min_max.hpp"

/// Arithmetic with one definition for host and device, so that both give the same bits.
namespace pierce {

/// The smallest float32 above zero.
inline constexpr float smallest_float = 0x1p-149f;

/// The float32 next to `f`, further from zero or closer to it. `f` is not zero.
PIERCE_HD inline float outward_neighbor(float f) {
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(f) + 1);
}
PIERCE_HD inline float inward_neighbor(float f) {
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(f) - 1);
}

/// A bound that is not above, or not below, the exact value of a float32 sum that was rounded to
/// `rounded`. The rounded sum is off by half an ulp at most, and exact where it is smaller than all
/// normal numbers. The bound is NaN for infinite input.
PIERCE_HD inline float not_above(float rounded) {
    return rounded - std::fabs(rounded) * std::numeric_limits<float>::epsilon();
}
PIERCE_HD inline float not_below(float rounded) {
    return rounded + std::fabs(rounded) * std::numeric_limits<float>::epsilon();
}

/// The nearest float32 that is not above `value`.
PIERCE_HD inline float round_down(double value) {
    const float f = static_cast<float>(value);
    if (!(static_cast<double>(f) > value)) return f;
    return f == 0 ? -smallest_float : f < 0 ? outward_neighbor(f) : inward_neighbor(f);
}

/// The nearest float32 that is not below `value`.
PIERCE_HD inline float round_up(double value) {
    const float f = static_cast<float>(value);
    if (!(static_cast<double>(f) < value)) return f;
    return f == 0 ? smallest_float : f > 0 ? outward_neighbor(f) : inward_neighbor(f);
}

/// The angle of the vector (x, y) from the x axis for y >= 0, in [0, pi] radians, with an error
/// below 2e-8 (Abramowitz and Stegun 1964, 4.4.49). Built from operations that IEEE 754 rounds
/// exactly; a library's atan2 differs between host and device.
PIERCE_HD inline double angle_of(double x, double y) {
    constexpr double pi = 3.14159265358979323846;
    const double wide = x < 0 ? -x : x;
    const double longer = max_of(wide, y);
    if (!(longer > 0)) return 0.0;
    const double r = min_of(wide, y) / longer, s = r * r;
    double p = 0.0028662257;
    p = p * s - 0.0161657367;
    p = p * s + 0.0429096138;
    p = p * s - 0.0752896400;
    p = p * s + 0.1065626393;
    p = p * s - 0.1420889944;
    p = p * s + 0.1999355085;
    p = p * s - 0.3333314528;
    const double small = r * (1.0 + s * p);
    const double acute = y > wide ? 0.5 * pi - small : small;
    return x < 0 ? pi - acute : acute;
}

}  // namespace pierce
