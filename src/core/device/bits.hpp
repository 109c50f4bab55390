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
#else
    return static_cast<std::uint32_t>(std::popcount(mask));
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
