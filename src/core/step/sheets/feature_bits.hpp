#pragma once

#include <cstdint>

#include "pierce/host_device.hpp"

namespace pierce::stages {

/// The features of two triangles that may meet or come close, a bit each. Of its corners and edges,
/// which it shares with other triangles, each triangle counts only those it owns
/// (TriangleFeatures::own).
struct FeatureBits {
    static constexpr std::uint32_t vertex_of_first = 0, vertex_of_second = 3;  ///< three each
    static constexpr std::uint32_t edges = 6;  ///< four for each edge of the first: one for each
                                               ///< edge of the second, and an unused one
    static constexpr std::uint32_t piercing_first = 18, piercing_second = 21;  ///< three each
    static constexpr std::uint32_t count = 24, all = (1u << count) - 1;
    static constexpr std::uint32_t open = 1u << 30;      ///< nothing is known yet
    static constexpr std::uint32_t separate = 1u << 31;  ///< the triangles do not meet

    /// The vertices and edges of two triangles with the features of the other one, of what the
    /// triangles own.
    PIERCE_HD static std::uint32_t owned(std::uint32_t own_of_first, std::uint32_t own_of_second) {
        const std::uint32_t others = own_of_second >> 3;
        const std::uint32_t both = (own_of_first >> 3 & 1) * others |
                                   (own_of_first >> 4 & 1) * others << 4 |
                                   (own_of_first >> 5 & 1) * others << 8;
        return (own_of_first & 7) << vertex_of_first | (own_of_second & 7) << vertex_of_second |
               both << edges;
    }
};

}  // namespace pierce::stages
