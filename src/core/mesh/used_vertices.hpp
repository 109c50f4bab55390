#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce {

/// Per vertex: whether a triangle has it. Others are allowed, and are no part of a body.
inline std::vector<bool> used_vertices(std::span<const Triangle> triangles, std::size_t vertices) {
    std::vector<bool> used(vertices, false);
    for (const Triangle& t : triangles)
        for (const std::uint32_t v : t.vertex) used[v] = true;
    return used;
}

}  // namespace pierce
