#include "pierce/core/mesh_edges.hpp"

#include <algorithm>
#include <numeric>

#include "pierce/core/disjoint_sets.hpp"
#include "pierce/core/edges.hpp"
#include "pierce/core/float_rules.hpp"
#include "pierce/core/patch.hpp"

namespace pierce {

MeshEdges edges_of(const MeshView& mesh) {
    std::vector<std::uint32_t> place(mesh.positions.size);
    for (std::uint32_t i = 0; i < mesh.patch_vertices.size; ++i) place[mesh.patch_vertices[i]] = i;

    MeshEdges made;
    for_each_edge({mesh.triangles.begin(), mesh.triangles.end()}, [&](std::span<const HalfEdge> sides) {
        std::uint32_t first = sides[0].low, second = sides[0].high;
        if (first == second) return;
        if (place[second] < place[first]) std::swap(first, second);
        if (sides.size() == 2 && sides[0].forward != sides[1].forward)
            made.edges.push_back({{first, second}, {sides[0].triangle, sides[1].triangle}});
        else
            for (const HalfEdge& side : sides) made.edges.push_back({{first, second}, {side.triangle, no_triangle}});
    });
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
    DisjointSets vertices = connected_vertices({mesh.triangles.begin(), mesh.triangles.end()}, mesh.positions.size);
    std::vector<std::uint32_t> parts;
    for (const Triangle& t : mesh.triangles) parts.push_back(vertices.root(t.vertex[0]));
    std::ranges::sort(parts);
    parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
    return parts;
}

}  // namespace pierce
