#pragma once

#include <cmath>

#include "pierce/core/config.hpp"

/// Arithmetic with one definition for host and device, so that both give the same bits.
namespace pierce {

/// The smaller of two numbers; the second if the first is NaN.
template <class T>
PIERCE_HD constexpr T min_of(T a, T b) {
    return a < b ? a : b;
}

/// The larger of two numbers; the second if the first is NaN.
template <class T>
PIERCE_HD constexpr T max_of(T a, T b) {
    return a > b ? a : b;
}

template <class T>
PIERCE_HD constexpr T clamp_to(T value, T low, T high) {
    return min_of(max_of(value, low), high);
}

/// The nearest float32 that is not above `value`.
PIERCE_HD inline float round_down(double value) {
    const float f = static_cast<float>(value);
    return static_cast<double>(f) > value ? std::nextafter(f, -INFINITY) : f;
}

/// The nearest float32 that is not below `value`.
PIERCE_HD inline float round_up(double value) {
    const float f = static_cast<float>(value);
    return static_cast<double>(f) < value ? std::nextafter(f, INFINITY) : f;
}

/// Arc cosine in radians with an error below 2.3e-8 (Abramowitz and Stegun 1964, 4.4.46).
/// Built from operations that IEEE 754 rounds exactly; a library's acos differs between host and device.
PIERCE_HD inline double arc_cosine(double cosine) {
    constexpr double pi = 3.14159265358979323846;
    const double c = clamp_to(cosine, -1.0, 1.0);
    const double x = c < 0 ? -c : c;
    double p = -0.0012624911;
    p = p * x + 0.0066700901;
    p = p * x - 0.0170881256;
    p = p * x + 0.0308918810;
    p = p * x - 0.0501743046;
    p = p * x + 0.0889789874;
    p = p * x - 0.2145988016;
    p = p * x + 1.5707963050;
    const double angle = std::sqrt(1.0 - x) * p;
    return c < 0 ? pi - angle : angle;
}

}  // namespace pierce
