#include "core/mesh_build/mesh_topology.hpp"

#include <algorithm>

#include "core/geometry/triangle.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"

namespace pierce {
namespace {

/// Counts the edges that break closedness, orientation or manifoldness.
void count_edges(const HalfEdges& sides_of_all, MeshTraits& traits) {
    sides_of_all.for_each_edge([&](std::span<const HalfEdge> sides) {
        traits.boundary_edges += sides.size() == 1;
        traits.non_manifold_edges += sides.size() > 2;
        traits.inconsistent_edges += !is_balanced(sides);
    });
}

}  // namespace

MeshTraits traits_of(const MeshData& data, const HalfEdges& sides, Vec3d origin) {
    MeshTraits traits;
    count_edges(sides, traits);
    double edges = 0;
    for (const Triangle& t : data.triangles) {
        Vec3d p[3];
        for (int k = 0; k < 3; ++k) p[k] = to_double(data.positions[t.vertex[k]]) - origin;
        traits.degenerate_triangles += is_degenerate(p[0], p[1], p[2]);
        traits.volume += dot(p[0], cross(p[1], p[2])) / 6;
        for (int k = 0; k < 3; ++k) edges += length(p[(k + 1) % 3] - p[k]);
    }
    traits.mean_edge_length = edges / (3.0 * static_cast<double>(data.triangles.size()));
    return traits;
}

std::pair<std::vector<std::uint32_t>, std::vector<Corner>> corners_by_vertex(
    std::span<const Triangle> triangles, std::size_t vertex_count) {
    std::vector<std::uint32_t> offsets(vertex_count + 1, 0);
    for (const Triangle& t : triangles)
        for (std::uint32_t v : t.vertex) ++offsets[v + 1];
    for (std::size_t v = 0; v < vertex_count; ++v) offsets[v + 1] += offsets[v];
    std::vector<Corner> corners(offsets.back());
    std::vector<std::uint32_t> next(offsets.begin(), offsets.end() - 1);
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k)
            corners[next[t.vertex[k]]++] = {t.vertex[(k + 1) % 3], t.vertex[(k + 2) % 3]};
    return {std::move(offsets), std::move(corners)};
}

std::vector<std::uint32_t> fans_of(std::span<const std::uint32_t> corner_offsets,
                                   std::span<const Corner> corners) {
    std::vector<std::uint32_t> fans(corners.size(), no_vertex);
    std::vector<std::uint32_t> fan;
    for (std::size_t v = 0; v + 1 < corner_offsets.size(); ++v) {
        const std::span<const Corner> at = corners.subspan(
            corner_offsets[v], corner_offsets[v + 1] - corner_offsets[v]);
        fan.clear();
        bool simple = at.size() >= 3;
        for (std::uint32_t next = simple ? at[0].next : no_vertex;
             simple && fan.size() < at.size();) {
            fan.push_back(next);
            const auto follows = [&](const Corner& c) { return c.next == next; };
            simple = std::ranges::count_if(at, follows) == 1;
            if (simple) next = std::ranges::find_if(at, follows)->previous;
            const bool closes = next == fan[0];
            simple = simple && closes == (fan.size() == at.size());
        }
        if (simple) std::ranges::copy(fan, fans.begin() + corner_offsets[v]);
    }
    return fans;
}

}  // namespace pierce
