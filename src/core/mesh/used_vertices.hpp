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

/// Per vertex, itself; for one that no triangle has, another one that stands in for it, so that
/// boxes around all places are those of the body.
inline std::vector<std::uint32_t> stand_ins(std::span<const Triangle> triangles,
                                            std::size_t vertices) {
    const std::vector<bool> used = used_vertices(triangles, vertices);
    std::vector<std::uint32_t> result(vertices);
    for (std::uint32_t v = 0; v < vertices; ++v) result[v] = used[v] ? v : triangles[0].vertex[0];
    return result;
}

}  // namespace pierce
