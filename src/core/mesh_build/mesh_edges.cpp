#include "core/mesh_build/mesh_edges.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/disjoint_sets.hpp"
#include "core/device/bits.hpp"
#include "core/mesh/edge_group.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/spatial_order.hpp"

namespace pierce {

std::vector<Edge> edges_of(const MeshView& mesh, const HalfEdges& sides_of_all, Workers& workers) {
    std::vector<Edge> edges;
    edges.reserve(3 * std::size_t{mesh.triangles.size} / 2);
    sides_of_all.for_each_edge([&](std::span<const HalfEdge> sides) {
        const std::uint32_t low = sides[0].low, high = sides[0].high;
        if (low == high) return;
        if (sides.size() == 2 && sides[0].forward != sides[1].forward)
            edges.push_back({{low, high}, {sides[0].triangle, sides[1].triangle}});
        else
            for (const HalfEdge& side : sides)
                edges.push_back({{low, high}, {side.triangle, no_triangle}});
    });
    std::vector<Vec3d> middles;
    middles.reserve(edges.size());
    for (const Edge& e : edges) middles.push_back(middle_of(e, mesh.positions));
    std::vector<Edge> ordered;
    ordered.reserve(edges.size());
    for (std::uint32_t e : spatial_order(middles, workers.threads())) ordered.push_back(edges[e]);
    return ordered;
}

std::vector<TriangleFeatures> features_of(const MeshView& mesh) {
    std::vector<TriangleFeatures> features(mesh.triangles.size,
                                           {{no_vertex, no_vertex, no_vertex}, 0});
    // Vertices are dealt out evenly, as a GPU's threads side by side take as long as the thread
    // with the most work. There are half as many vertices as triangles. So each triangle first gets
    // one of its vertices that is free, and then the rest are dealt out.
    std::vector<bool> owned(mesh.positions.size, false);
    for (const bool one_each : {true, false})
        for (std::uint32_t t = 0; t < mesh.triangles.size; ++t)
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t v = mesh.triangles[t].vertex[k];
                if (owned[v] || (one_each && features[t].own != 0)) continue;
                features[t].own |= 1u << k;
                owned[v] = true;
            }
    for (std::uint32_t e = 0; e < mesh.edges.size; ++e) {
        const Edge& edge = mesh.edges[e];
        std::uint32_t own[2] = {}, fewest = 4, owner = 0;
        for (std::uint32_t side = 0; side < 2; ++side) {
            if (edge.triangle[side] == no_triangle) continue;
            const Triangle& t = mesh.triangles[edge.triangle[side]];
            TriangleFeatures& of = features[edge.triangle[side]];
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t v = t.vertex[k], w = t.vertex[(k + 1) % 3];
                if (std::minmax(v, w) != std::minmax(edge.vertex[0], edge.vertex[1])) continue;
                of.edge[k] = e;
                own[side] = 8u << k;
            }
            const std::uint32_t count = bit_count(of.own >> 3);
            if (count < fewest) {
                fewest = count;
                owner = side;
            }
        }
        features[edge.triangle[owner]].own |= own[owner];
    }
    return features;
}

std::vector<MeshPart> parts_of(const MeshView& mesh) {
    DisjointSets vertices = connected_vertices({mesh.triangles.begin(), mesh.triangles.end()},
                                               mesh.positions.size);
    std::map<std::uint32_t, MeshPart> parts;
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t.vertex) {
            const std::uint32_t root = vertices.root(v);
            parts.try_emplace(root, MeshPart{{root, root, root, root}});
        }
    const auto place = [&](std::uint32_t v) { return to_double(mesh.positions[v]); };
    // How far a vertex is from the first `k` of its part, up to a factor that they share.
    const auto distance = [&](const MeshPart& part, std::uint32_t k, std::uint32_t v) {
        const Vec3d first = place(part.vertex[0]), from = place(v) - first,
                    second = place(part.vertex[1]) - first, third = place(part.vertex[2]) - first;
        return k == 1   ? length_squared(from)
               : k == 2 ? length_squared(cross(second, from))
                        : std::fabs(dot(cross(second, third), from));
    };
    for (std::uint32_t k = 1; k < MeshPart::count; ++k)
        for (std::uint32_t v = 0; v < mesh.positions.size; ++v) {
            const auto part = parts.find(vertices.root(v));
            if (part == parts.end()) continue;  // of no triangle
            MeshPart& p = part->second;
            if (distance(p, k, v) > distance(p, k, p.vertex[k])) p.vertex[k] = v;
        }
    std::vector<MeshPart> result;
    result.reserve(parts.size());
    for (const auto& [root, part] : parts) result.push_back(part);
    return result;
}

}  // namespace pierce
