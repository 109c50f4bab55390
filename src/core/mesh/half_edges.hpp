#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce {

/// A triangle's side: it lies opposite the triangle's corner `opposite` and joins the vertices
/// `low` and `high`, low <= high.
struct HalfEdge {
    std::uint32_t low, high;
    std::uint32_t triangle;
    std::uint8_t opposite;
    bool forward;  ///< the triangle runs through its side from `low` to `high`
};

/// Calls visit(sides) for every edge, in order of its vertices, with the sides of all triangles
/// that meet there, in order of their triangles.
template <class F>
void for_each_edge(std::span<const Triangle> triangles, F visit) {
    std::vector<HalfEdge> sides;
    sides.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::uint8_t k = 0; k < 3; ++k) {
            const std::uint32_t from = triangles[t].vertex[(k + 1) % 3],
                                to = triangles[t].vertex[(k + 2) % 3];
            sides.push_back({.low = std::min(from, to),
                             .high = std::max(from, to),
                             .triangle = t,
                             .opposite = k,
                             .forward = from < to});
        }
    const auto edge_of = [](const HalfEdge& s) { return std::uint64_t{s.low} << 32 | s.high; };
    std::ranges::sort(sides, [&](const HalfEdge& s, const HalfEdge& other) {
        return edge_of(s) != edge_of(other) ? edge_of(s) < edge_of(other)
                                            : s.triangle < other.triangle;
    });
    for (auto first = sides.begin(); first != sides.end();) {
        const auto last = std::find_if(
            first, sides.end(), [&](const HalfEdge& s) { return edge_of(s) != edge_of(*first); });
        visit(std::span<const HalfEdge>(first, last));
        first = last;
    }
}

/// True if as many triangles run through the edge one way as the other; a surface all of whose
/// edges are balanced is closed.
inline bool is_balanced(std::span<const HalfEdge> sides) {
    return 2 * std::ranges::count(sides, true, &HalfEdge::forward) == std::ssize(sides);
}

}  // namespace pierce
