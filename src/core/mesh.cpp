#include "pierce/core/mesh.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "pierce/core/bvh/leaves.hpp"
#include "pierce/core/constants.hpp"
#include "pierce/core/edges.hpp"
#include "pierce/core/error.hpp"
#include "pierce/core/mesh_edges.hpp"
#include "pierce/core/patch.hpp"
#include "pierce/core/spatial_order.hpp"
#include "pierce/core/star_clearance.hpp"
#include "pierce/core/triangle.hpp"
#include "pierce/core/triangle_rings.hpp"
#include "pierce/core/vertex_normal.hpp"

namespace pierce {
namespace {

void check_indices(const std::string& name, const MeshData& data) {
    for (std::size_t t = 0; t < data.triangles.size(); ++t)
        for (std::uint32_t v : data.triangles[t].vertex)
            if (v >= data.positions.size())
                throw InputError("mesh '" + name + "': triangle " + std::to_string(t) + " names vertex " +
                                 std::to_string(v) + ", but there are " + std::to_string(data.positions.size()));
}

/// Counts the edges that break closedness, orientation or manifoldness.
void count_edges(std::span<const Triangle> triangles, MeshTraits& traits) {
    for_each_edge(triangles, [&](std::span<const HalfEdge> sides) {
        traits.boundary_edges += sides.size() == 1;
        traits.non_manifold_edges += sides.size() > 2;
        traits.inconsistent_edges += !is_balanced(sides);
    });
}

}  // namespace

MeshTraits traits_of(const MeshData& data, Vec3d origin) {
    MeshTraits traits;
    count_edges(data.triangles, traits);
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

std::pair<std::vector<std::uint32_t>, std::vector<Corner>> corners_of(std::span<const Triangle> triangles,
                                                                      std::size_t vertex_count) {
    std::vector<std::uint32_t> offsets(vertex_count + 1, 0);
    for (const Triangle& t : triangles)
        for (std::uint32_t v : t.vertex) ++offsets[v + 1];
    for (std::size_t v = 0; v < vertex_count; ++v) offsets[v + 1] += offsets[v];
    std::vector<Corner> corners(offsets.back());
    std::vector<std::uint32_t> next(offsets.begin(), offsets.end() - 1);
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) corners[next[t.vertex[k]]++] = {t.vertex[(k + 1) % 3], t.vertex[(k + 2) % 3]};
    return {std::move(offsets), std::move(corners)};
}

std::vector<std::uint32_t> fans_of(std::span<const std::uint32_t> corner_offsets, std::span<const Corner> corners) {
    std::vector<std::uint32_t> fans(corners.size(), no_vertex);
    for (std::size_t v = 0; v + 1 < corner_offsets.size(); ++v) {
        const std::span<const Corner> at = corners.subspan(corner_offsets[v], corner_offsets[v + 1] - corner_offsets[v]);
        std::vector<std::uint32_t> fan;
        bool simple = at.size() >= 3;
        for (std::uint32_t next = simple ? at[0].next : no_vertex; simple && fan.size() < at.size();) {
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

void check_positions(const std::string& name, std::span<const Vec3f> positions) {
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (!is_within_reach(positions[v]))
            throw InputError("'" + name + "': vertex " + std::to_string(v) +
                             (is_finite(positions[v]) ? " is too far away" : " is not finite"));
}

Mesh::Mesh(std::string name, MeshData data) : name_(std::move(name)), data_(std::move(data)) {
    if (data_.triangles.empty()) throw InputError("mesh '" + name_ + "' has no triangles");
    check_positions(name_, data_.positions);
    check_indices(name_, data_);
    if (std::max(data_.positions.size(), 3 * data_.triangles.size()) > constants::max_elements)
        throw InputError("mesh '" + name_ + "' has more than " + std::to_string(constants::max_elements) +
                         " vertices or corners");

    Vec3d sum;
    for (Vec3f p : data_.positions) {
        box_.extend(to_double(p));
        sum += to_double(p);
    }
    centroid_ = sum * (1.0 / static_cast<double>(data_.positions.size()));
    traits_ = traits_of(data_, centroid_);
    std::tie(corner_offsets_, corners_) = corners_of(data_.triangles, data_.positions.size());
    fans_ = fans_of(corner_offsets_, corners_);
    std::vector<Vec3d> points;
    for (Vec3f p : data_.positions) points.push_back(to_double(p));
    patch_vertices_ = spatial_order(points);
    std::vector<Vec3d> middles;
    for (const Triangle& t : data_.triangles)
        middles.push_back((1.0 / 3) * (points[t.vertex[0]] + points[t.vertex[1]] + points[t.vertex[2]]));
    group_triangles_ = spatial_order(middles);
    leaves_ = bvh::leaves_of(data_.positions, data_.triangles);
    MeshEdges edges = edges_of(view());
    edges_ = std::move(edges.edges);
    edge_offsets_ = std::move(edges.offsets);
    edge_reach_ = std::move(edges.reach);
    features_ = features_of(view());
    parts_ = parts_of(view());
    neighbors_ = neighbors_of(data_.triangles);
    if (traits_.closed()) {
        rings_ = rings_of(view());
        simple_ = traits_.volume > 0 && parts_.size() == 1 &&
                  std::ranges::all_of(rings_, [](const TriangleRing& r) { return r.gap > 0 && r.openness > 0; });
        star_clearance_ = star_clearance(view());
        clearance_ = build_clearance_grid(data_.positions, data_.triangles);
    }

    const MeshView mesh = view();
    normals_.reserve(data_.positions.size());
    for (std::uint32_t v = 0; v < data_.positions.size(); ++v)
        normals_.push_back(to_float(vertex_normal(mesh, mesh.positions, v)));
    blocks_.resize(block_count(mesh));
    patches_.resize(patch_count(mesh));
    for (std::uint32_t p = 0; p < patch_count(mesh); ++p)
        measure_patch(mesh, mesh.positions, p, blocks_[p / constants::block_size], patches_[p]);
    for (std::uint32_t b = 0; b < block_count(mesh); ++b) finish_block(mesh, mesh.positions, b, blocks_[b]);
}

MeshView Mesh::view() const {
    return {view_of(data_.positions),
            view_of(normals_),
            view_of(data_.triangles),
            view_of(corner_offsets_),
            view_of(corners_),
            view_of(fans_),
            view_of(patch_vertices_),
            view_of(blocks_),
            view_of(patches_),
            view_of(edges_),
            view_of(edge_offsets_),
            view_of(edge_reach_),
            view_of(features_),
            view_of(group_triangles_),
            view_of(leaves_),
            view_of(parts_),
            view_of(neighbors_),
            view_of(rings_),
            view_of(star_clearance_),
            clearance_.view(),
            box_,
            centroid_,
            traits_.mean_edge_length,
            traits_.closed(),
            simple_};
}

}  // namespace pierce
