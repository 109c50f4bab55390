#pragma once

#include <bit>
#include <cstdint>

#include "pierce/host_device.hpp"

/// Bits of masks, on host and device: the standard library's functions run on the host only.
namespace pierce {

/// How many bits are set.
PIERCE_HD inline std::uint32_t bit_count(std::uint32_t mask) {
#if defined(__CUDA_ARCH__)
    return static_cast<std::uint32_t>(__popc(mask));
#elif defined(__POPCNT__) || !defined(__x86_64__)
    return static_cast<std::uint32_t>(std::popcount(mask));
#else
    // Without the instruction, std::popcount() calls a function. Sums of neighbouring bits do not.
    mask -= mask >> 1 & 0x55555555u;
    mask = (mask & 0x33333333u) + (mask >> 2 & 0x33333333u);
    return ((mask + (mask >> 4)) & 0x0f0f0f0fu) * 0x01010101u >> 24;
#endif
}

/// The place of the lowest bit that is set; there must be one.
PIERCE_HD inline std::uint32_t lowest_bit(std::uint32_t mask) {
#if defined(__CUDA_ARCH__)
    return static_cast<std::uint32_t>(__ffs(static_cast<int>(mask)) - 1);
#else
    return static_cast<std::uint32_t>(std::countr_zero(mask));
#endif
}

}  // namespace pierce
