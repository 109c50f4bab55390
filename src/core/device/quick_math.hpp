#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "pierce/min_max.hpp"

/// float32 arithmetic in the instructions that a device is fastest at.
namespace pierce {

/// The smaller and the larger of two numbers that are not NaN. They take one instruction on a GPU,
/// where min_of and max_of take two. Of two zeros with different signs, either may be the result.
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

/// The number limited to [0, 1]; NaN becomes 0 or 1. On a GPU this is part of another instruction,
/// elsewhere it takes no branch.
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
#elif defined(PIERCE_FUSED_PRODUCTS)
    return std::fma(a, b, c);
#else
    return a * b + c;
#endif
}

}  // namespace pierce
