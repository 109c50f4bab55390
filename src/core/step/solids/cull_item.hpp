#pragma once

#include <cstdint>

#include "core/device/bits.hpp"
#include "pierce/host_device.hpp"

namespace pierce::stages {

/// A block, or a part of one, of a directed pair's source: of its patches or groups of edges.
struct CullItem {
    std::uint32_t directed = 0;
    std::uint32_t index = 0;
};

/// Writes those of an item's `size` parts that have a bit in the mask, from a place on.
PIERCE_HD inline void write_parts(const CullItem& item, std::uint32_t size, std::uint32_t mask,
                                  std::uint32_t place, CullItem* parts) {
    for (; mask != 0; mask &= mask - 1)
        parts[place++] = {item.directed, item.index * size + lowest_bit(mask)};
}

/// Writes the first `count` blocks of a directed pair's source, from a place on.
PIERCE_HD inline void write_blocks(std::uint32_t directed, std::uint32_t count, std::uint32_t place,
                                   CullItem* blocks) {
    for (std::uint32_t b = 0; b < count; ++b) blocks[place + b] = {directed, b};
}

}  // namespace pierce::stages
