#pragma once

#include <cstdint>

#include "pierce/host_device.hpp"
#include "pierce/ids.hpp"

namespace pierce::bvh {

/// A leaf of a tree: a triangle, or two that share an edge. The first triangle's corners are 0, 1,
/// 2, the second one's are 3, 2, 1, each in either orientation.
struct alignas(16) Leaf {
    std::uint32_t corner[4] = {};
    std::uint32_t triangle[2] = {no_triangle, no_triangle};  ///< the second one is no_triangle if
                                                             ///< the leaf has one triangle
    std::uint32_t padding[2] = {};

    PIERCE_HD std::uint32_t size() const { return triangle[1] == no_triangle ? 1 : 2; }
};

}  // namespace pierce::bvh
