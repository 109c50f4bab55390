#pragma once

#include "pierce/host_device.hpp"

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

/// `value`, but not below `low` nor above `high`.
template <class T>
PIERCE_HD constexpr T clamp_to(T value, T low, T high) {
    return min_of(max_of(value, low), high);
}

}  // namespace pierce
