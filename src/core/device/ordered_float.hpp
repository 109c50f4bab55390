#pragma once

#include <bit>
#include <cstdint>

#include "pierce/host_device.hpp"

/// Numbers as integers in the same order, so that they can be sorted, and the least of them found
/// by atomic operations. The least of many numbers does not depend on the order in which they come,
/// so a result stays the same however the work is shared out.
namespace pierce {

/// An integer that orders like the number; -0 comes before +0.
PIERCE_HD inline std::uint32_t ordered_bits(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/// The number that an integer was made from.
PIERCE_HD inline float from_ordered_bits(std::uint32_t ordered) {
    return std::bit_cast<float>(ordered & 0x80000000u ? ordered & 0x7fffffffu : ~ordered);
}

}  // namespace pierce
