#include "pierce/core/mesh_edges.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "pierce/core/float_rules.hpp"
#include "pierce/core/patch.hpp"

namespace pierce {
namespace {

struct HalfEdge {
    std::uint32_t low, high;
    std::uint32_t triangle;
    bool ascends;
};

std::vector<HalfEdge> sorted_half_edges(std::span<const Triangle> triangles) {
    std::vector<HalfEdge> half_edges;
    half_edges.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = triangles[t].vertex[k], b = triangles[t].vertex[(k + 1) % 3];
            if (a != b) half_edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
        }
    std::ranges::sort(half_edges, {}, [](const HalfEdge& h) { return std::tuple(h.low, h.high, h.triangle); });
    return half_edges;
}

}  // namespace

MeshEdges edges_of(const MeshView& mesh) {
    std::vector<std::uint32_t> place(mesh.positions.size);
    for (std::uint32_t i = 0; i < mesh.patch_vertices.size; ++i) place[mesh.patch_vertices[i]] = i;

    MeshEdges made;
    const std::vector<HalfEdge> half_edges = sorted_half_edges({mesh.triangles.begin(), mesh.triangles.end()});
    for (std::size_t i = 0, end = 0; i < half_edges.size(); i = end) {
        while (end < half_edges.size() && half_edges[end].low == half_edges[i].low &&
               half_edges[end].high == half_edges[i].high)
            ++end;
        std::uint32_t first = half_edges[i].low, second = half_edges[i].high;
        if (place[second] < place[first]) std::swap(first, second);
        if (end - i == 2 && half_edges[i].ascends != half_edges[i + 1].ascends)
            made.edges.push_back({{first, second}, {half_edges[i].triangle, half_edges[i + 1].triangle}});
        else
            for (std::size_t h = i; h < end; ++h)
                made.edges.push_back({{first, second}, {half_edges[h].triangle, no_triangle}});
    }
    std::ranges::stable_sort(made.edges, {}, [&](const Edge& e) { return place[e.vertex[0]]; });

    made.offsets.assign(patch_count(mesh) + 1, 0);
    made.reach.assign(patch_count(mesh), 0.0f);
    for (const Edge& e : made.edges) {
        const std::uint32_t p = place[e.vertex[0]] / constants::patch_size;
        ++made.offsets[p + 1];
        const double size = length(to_double(mesh.positions[e.vertex[1]]) - to_double(mesh.positions[e.vertex[0]]));
        made.reach[p] = std::max(made.reach[p], round_up(size));
    }
    std::partial_sum(made.offsets.begin(), made.offsets.end(), made.offsets.begin());
    return made;
}

std::vector<std::uint32_t> parts_of(const MeshView& mesh) {
    std::vector<std::uint32_t> parent(mesh.positions.size);
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (const Triangle& t : mesh.triangles)
        for (int k = 1; k < 3; ++k) parent[root(t.vertex[k])] = root(t.vertex[0]);
    std::vector<std::uint32_t> parts;
    for (const Triangle& t : mesh.triangles) parts.push_back(root(t.vertex[0]));
    std::ranges::sort(parts);
    parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
    return parts;
}

}  // namespace pierce
