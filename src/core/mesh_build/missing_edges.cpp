#include "core/mesh_build/missing_edges.hpp"

#include <algorithm>

#include "core/mesh/half_edges.hpp"

namespace pierce {

std::vector<MissingEdge> missing_edges(std::span<const Triangle> triangles,
                                       std::size_t vertex_count) {
    std::vector<MissingEdge> missing;
    HalfEdges(triangles, vertex_count).for_each_edge([&](std::span<const HalfEdge> sides) {
        const std::ptrdiff_t forward = std::ranges::count(sides, true, &HalfEdge::forward);
        const std::ptrdiff_t more = 2 * forward - std::ssize(sides);
        const auto [low, high] = std::pair{sides[0].low, sides[0].high};
        for (std::ptrdiff_t i = 0; i < more; ++i) missing.push_back({high, low});
        for (std::ptrdiff_t i = 0; i < -more; ++i) missing.push_back({low, high});
    });
    std::ranges::sort(missing);
    return missing;
}

}  // namespace pierce
