#include "core/mesh_build/mesh_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "core/device/bits.hpp"
#include "core/mesh/edge_group.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/connected_parts.hpp"
#include "core/mesh_build/kept_order.hpp"
#include "core/mesh_build/spatial_order.hpp"

namespace pierce {

namespace {

/// Per edge before, which of the edges it is now, or is_gone. `now` is in the order of its
/// vertices.
std::vector<std::uint32_t> numbers_now(View<const Edge> before, const std::vector<Edge>& now) {
    const std::uint32_t vertices = now.empty() ? 0 : now.back().vertex[0] + 1;
    std::vector<std::uint32_t> begin(vertices + 1, 0);  // per vertex, of the edges that begin there
    for (const Edge& e : now) ++begin[e.vertex[0] + 1];
    for (std::uint32_t v = 0; v < vertices; ++v) begin[v + 1] += begin[v];

    std::vector<std::uint32_t> numbers(before.size, is_gone);
    std::vector<bool> taken(now.size(), false);
    for (std::uint32_t e = 0; e < before.size; ++e) {
        const auto [low, high] = std::to_array(before[e].vertex);
        if (low >= vertices) continue;
        for (std::uint32_t n = begin[low]; n < begin[low + 1]; ++n) {
            if (now[n].vertex[1] != high || taken[n]) continue;
            taken[n] = true;
            numbers[e] = n;
            break;
        }
    }
    return numbers;
}

/// An order near the one that the edges had before.
std::vector<std::uint32_t> order_before(View<const Edge> before, const std::vector<Edge>& now) {
    std::vector<std::uint32_t> all(before.size);
    std::iota(all.begin(), all.end(), 0u);
    return kept_order(all, numbers_now(before, now), static_cast<std::uint32_t>(now.size()));
}

}  // namespace

std::vector<Edge> edges_of(const MeshView& mesh, const HalfEdges& sides_of_all, Workers& workers,
                           const View<const Edge>* before) {
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
    std::vector<Vec3f> middles;
    middles.reserve(edges.size());
    for (const Edge& e : edges) middles.push_back(to_float(middle_of(e, mesh.positions)));
    const std::vector<std::uint32_t> start = before != nullptr ? order_before(*before, edges)
                                                               : std::vector<std::uint32_t>();
    std::vector<Edge> ordered;
    ordered.reserve(edges.size());
    for (std::uint32_t e : spatial_order(middles, constants::group_size, workers.threads(), start))
        ordered.push_back(edges[e]);
    return ordered;
}

namespace {

/// Gives one of three edges that a triangle has to a neighbour that has fewer than two.
void relieve(const MeshView& mesh, TriangleFeatures& of, std::vector<TriangleFeatures>& features) {
    const auto owned_edges = [](const TriangleFeatures& f) { return bit_count(f.own >> 3); };
    for (std::uint32_t k = 0; k < 3 && owned_edges(of) == 3; ++k)
        for (const std::uint32_t t : mesh.edges[of.edge[k]].triangle) {
            if (t == no_triangle || owned_edges(features[t]) > 1) continue;
            const std::uint32_t* const edges = features[t].edge;
            const std::ptrdiff_t place = std::find(edges, edges + 3, of.edge[k]) - edges;
            of.own ^= 8u << k;
            features[t].own |= 8u << place;
            break;
        }
}

}  // namespace

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
    for (TriangleFeatures& of : features) relieve(mesh, of, features);
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
