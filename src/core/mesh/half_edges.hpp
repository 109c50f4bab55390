#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
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

/// The sides of some triangles, edge by edge.
class HalfEdges {
public:
    /// Takes time in proportion to the triangles. Indices must be below `vertex_count`.
    HalfEdges(std::span<const Triangle> triangles, std::size_t vertex_count)
        : sides_(3 * triangles.size()) {
        std::vector<std::uint32_t> place(vertex_count + 1, 0);
        const auto for_each_side = [&](auto&& f) {
            for (std::uint32_t t = 0; t < triangles.size(); ++t)
                for (std::uint8_t k = 0; k < 3; ++k) {
                    const std::uint32_t from = triangles[t].vertex[(k + 1) % 3],
                                        to = triangles[t].vertex[(k + 2) % 3];
                    f(HalfEdge{.low = std::min(from, to),
                               .high = std::max(from, to),
                               .triangle = t,
                               .opposite = k,
                               .forward = from < to});
                }
        };
        for_each_side([&](const HalfEdge& side) { ++place[side.low + 1]; });
        for (std::size_t v = 0; v < vertex_count; ++v) place[v + 1] += place[v];
        const std::vector<std::uint32_t> begin = place;
        for_each_side([&](const HalfEdge& side) { sides_[place[side.low]++] = side; });
        for (std::size_t v = 0; v < vertex_count; ++v)
            std::sort(sides_.begin() + begin[v], sides_.begin() + begin[v + 1],
                      [](const HalfEdge& s, const HalfEdge& other) {
                          return std::tie(s.high, s.triangle, s.opposite) <
                                 std::tie(other.high, other.triangle, other.opposite);
                      });
    }

    /// Calls visit(sides) for every edge, in order of its vertices, with the sides of all triangles
    /// that meet there, in order of their triangles.
    template <class F>
    void for_each_edge(F visit) const {
        for (auto first = sides_.begin(); first != sides_.end();) {
            const auto last = std::find_if(first, sides_.end(), [&](const HalfEdge& s) {
                return s.low != first->low || s.high != first->high;
            });
            visit(std::span<const HalfEdge>(first, last));
            first = last;
        }
    }

private:
    std::vector<HalfEdge> sides_;
};

/// True if as many triangles run through the edge one way as the other; a surface all of whose
/// edges are balanced is closed.
inline bool is_balanced(std::span<const HalfEdge> sides) {
    return 2 * std::ranges::count(sides, true, &HalfEdge::forward) == std::ssize(sides);
}

}  // namespace pierce
