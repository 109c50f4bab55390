#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

#include "pierce/vec3.hpp"

namespace pierce {

/// Per vertex, the first vertex at the same position; itself where a coordinate is not finite.
inline std::vector<std::uint32_t> first_at_position(std::span<const Vec3f> positions) {
    std::vector<std::uint32_t> first(positions.size());
    std::iota(first.begin(), first.end(), 0u);
    std::vector<std::uint32_t> order;
    for (std::uint32_t v : first)
        if (is_finite(positions[v])) order.push_back(v);
    const auto key = [&](std::uint32_t v) {
        return std::tuple{positions[v].x, positions[v].y, positions[v].z, v};
    };
    std::ranges::sort(order, {}, key);
    for (std::size_t i = 1; i < order.size(); ++i)
        if (positions[order[i]] == positions[order[i - 1]]) first[order[i]] = first[order[i - 1]];
    return first;
}

}  // namespace pierce
