#pragma once

#include <cstdint>

#include "pierce/host_device.hpp"

namespace pierce {

/// The first of `count` places that is_before(place) does not hold for; it holds for those before
/// and for none after.
template <class IsBefore>
PIERCE_HD std::uint32_t partition_point(std::uint32_t count, const IsBefore& is_before) {
    std::uint32_t low = 0, high = count;
    while (low < high) {
        const std::uint32_t middle = low + (high - low) / 2;
        const bool before = is_before(middle);
        (before ? low : high) = before ? middle + 1 : middle;
    }
    return low;
}

}  // namespace pierce
