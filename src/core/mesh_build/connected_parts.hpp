#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/base/disjoint_sets.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// The vertices, joined to sets by the triangles that connect them.
inline DisjointSets connected_vertices(std::span<const Triangle> triangles,
                                       std::size_t vertex_count) {
    DisjointSets sets(vertex_count);
    for (const Triangle& t : triangles)
        for (int k = 1; k < 3; ++k) sets.join(t.vertex[k], t.vertex[0]);
    return sets;
}

/// The connected parts of a surface: triangles that vertices connect.
struct ConnectedParts {
    std::vector<std::uint32_t> part;  ///< per triangle
    std::uint32_t count = 0;
};

/// Parts are numbered in the order of their first triangles.
inline ConnectedParts connected_parts(std::span<const Triangle> triangles,
                                      std::size_t vertex_count) {
    DisjointSets vertices = connected_vertices(triangles, vertex_count);
    ConnectedParts parts;
    parts.part.reserve(triangles.size());
    std::unordered_map<std::uint32_t, std::uint32_t> number;  // by root
    for (const Triangle& t : triangles) {
        const auto [known, is_new] = number.try_emplace(vertices.root(t.vertex[0]), parts.count);
        if (is_new) ++parts.count;
        parts.part.push_back(known->second);
    }
    return parts;
}

}  // namespace pierce
