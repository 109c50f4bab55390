#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "pierce/min_max.hpp"

/// float32 arithmetic in the instructions that a device is fastest at.
namespace pierce {

/// The smaller and the larger of two numbers that are not NaN: one instruction on a GPU, where the
/// ones above are two. Of zeros of different sign, any.
PIERCE_HD inline float quick_min(float a, float b) {
#if defined(__CUDA_ARCH__)
    return fminf(a, b);
#else
    return min_of(a, b);
#endif
}
PIERCE_HD inline float quick_max(float a, float b) {
#if defined(__CUDA_ARCH__)
    return fmaxf(a, b);
#else
    return max_of(a, b);
#endif
}

/// What is below 0 becomes 0, what is above 1 becomes 1, and what is not a number one of the two:
/// on a GPU as part of another instruction, elsewhere without a branch.
PIERCE_HD inline float quick_clamp(float a) {
#if defined(__CUDA_ARCH__)
    return __saturatef(a);
#else
    const auto bits = std::bit_cast<std::int32_t>(a), positive = bits & ~(bits >> 31);
    return std::bit_cast<float>(min_of(positive, std::bit_cast<std::int32_t>(1.0f)));
#endif
}

/// a * b + c.
PIERCE_HD inline float quick_fma(float a, float b, float c) {
#if defined(__CUDA_ARCH__)
    return __fmaf_rn(a, b, c);
#else
    return a * b + c;
#endif
}

}  // namespace pierce
