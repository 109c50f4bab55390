#include "pierce/mesh.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/base/reach.hpp"
#include "core/device/view.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/edge_group.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "core/mesh_build/leaves.hpp"
#include "core/mesh_build/mesh_edges.hpp"
#include "core/mesh_build/mesh_topology.hpp"
#include "core/mesh_build/own_exits.hpp"
#include "core/mesh_build/slab_grid.hpp"
#include "core/mesh_build/spatial_order.hpp"
#include "core/mesh_build/star_clearance.hpp"
#include "core/mesh_build/triangle_rings.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"

namespace pierce {
namespace {

template <class T>
using Vector = std::vector<T>;

void check_indices(const std::string& name, const MeshData& data) {
    for (std::size_t t = 0; t < data.triangles.size(); ++t)
        for (std::uint32_t v : data.triangles[t].vertex)
            if (v >= data.positions.size())
                throw InputError("mesh '" + name + "': triangle " + std::to_string(t) +
                                 " names vertex " + std::to_string(v) + ", but there are " +
                                 std::to_string(data.positions.size()));
}

}  // namespace

/// What a Mesh owns. The arrays are filled one after the other. The code that fills one reads
/// earlier ones through `view`.
struct Mesh::Parts {
    std::string name;
    MeshTraits traits;
    MeshArrays<Vector> arrays;
    MeshView view;

    Parts(std::string its_name, MeshData data);

    void see_arrays() {
        for_each_array([](auto& seen, const auto& owned) { seen = view_of(owned); }, view, arrays);
    }
    void divide_into_patches();
    void find_edges();
    void measure_solid();
    void measure_patches();
};

Mesh::Parts::Parts(std::string its_name, MeshData data) : name(std::move(its_name)) {
    if (data.triangles.empty()) throw InputError("mesh '" + name + "' has no triangles");
    check_positions(name, data.positions);
    check_indices(name, data);
    if (std::max(data.positions.size(), 3 * data.triangles.size()) > constants::max_elements)
        throw InputError("mesh '" + name + "' has more than " +
                         std::to_string(constants::max_elements) + " vertices or corners");

    Vec3d sum;
    for (Vec3f p : data.positions) {
        view.box.extend(to_double(p));
        sum += to_double(p);
    }
    view.centroid = sum * (1.0 / static_cast<double>(data.positions.size()));
    traits = traits_of(data, view.centroid);
    view.mean_edge_length = traits.mean_edge_length;
    view.closed = traits.closed();
    arrays.positions = std::move(data.positions);
    arrays.triangles = std::move(data.triangles);
    std::tie(arrays.corner_offsets, arrays.corners) = corners_of(arrays.triangles,
                                                                 arrays.positions.size());
    arrays.fans = fans_of(arrays.corner_offsets, arrays.corners);
    divide_into_patches();
    find_edges();
    if (view.closed) measure_solid();
    measure_patches();
}

void Mesh::Parts::divide_into_patches() {
    std::vector<Vec3d> points, middles;
    for (Vec3f p : arrays.positions) points.push_back(to_double(p));
    for (const Triangle& t : arrays.triangles)
        middles.push_back((1.0 / 3) *
                          (points[t.vertex[0]] + points[t.vertex[1]] + points[t.vertex[2]]));
    arrays.patch_vertices = spatial_order(points);
    arrays.group_triangles = spatial_order(middles);
    arrays.leaves = bvh::leaves_of(arrays.positions, arrays.triangles);
    see_arrays();
    const BoxLevels levels(view.triangles.size);
    arrays.box_nodes.resize(levels.nodes());
    for (std::uint32_t n = 0; n < levels.nodes(); ++n)
        measure_node(view, view.positions, levels, n, view_of(arrays.box_nodes));
    see_arrays();
}

void Mesh::Parts::find_edges() {
    arrays.edges = edges_of(view);
    see_arrays();
    arrays.edge_groups.resize(edge_group_count(view));
    arrays.edge_blocks.resize(edge_block_count(view));
    for (std::uint32_t b = 0; b < edge_block_count(view); ++b)
        measure_edge_block(view, b, arrays.edge_blocks[b], view_of(arrays.edge_groups));
    arrays.features = features_of(view);
    arrays.parts = parts_of(view);
    arrays.neighbors = neighbors_of(arrays.triangles);
    for (std::uint32_t v = 0; v < arrays.positions.size(); ++v)
        arrays.normals.push_back(to_float(vertex_normal(view, view.positions, v)));
    see_arrays();
}

void Mesh::Parts::measure_solid() {
    arrays.rings = rings_of(view);
    view.simple = traits.volume > 0 && arrays.parts.size() == 1 &&
                  std::ranges::all_of(arrays.rings, [](const TriangleRing& r) {
                      return r.gap > 0 && r.openness > 0;
                  });
    arrays.star_clearance = star_clearance(view);
    ClearanceGrid clearance = build_clearance_grid(arrays.positions, arrays.triangles);
    const ClearanceGrid coarse = build_clearance_grid(arrays.positions, arrays.triangles,
                                                      slab_resolution(arrays.triangles.size()));
    SlabGrid slabs = build_slab_grid(coarse, arrays.positions, arrays.triangles);
    view.slabs_at = coarse.layout;
    arrays.slab_cells = std::move(slabs.cells);
    arrays.slabs = std::move(slabs.slabs);
    arrays.clearance_steps = std::move(clearance.steps);
    view.clearance_at = clearance.layout;
    arrays.own_exit = own_exits_of(view);
}

void Mesh::Parts::measure_patches() {
    arrays.blocks.resize(block_count(view));
    arrays.patches.resize(patch_count(view));
    for (std::uint32_t p = 0; p < patch_count(view); ++p)
        measure_patch(view, view.positions, p, arrays.blocks[p / constants::block_size],
                      arrays.patches[p]);
    for (std::uint32_t b = 0; b < block_count(view); ++b)
        finish_block(view, view.positions, b, arrays.blocks[b]);
    see_arrays();
}

Mesh::Mesh(std::string name, MeshData data)
    : parts_(std::make_unique<Parts>(std::move(name), std::move(data))) {}
Mesh::Mesh(Mesh&&) noexcept = default;
Mesh& Mesh::operator=(Mesh&&) noexcept = default;
Mesh::~Mesh() = default;

const std::string& Mesh::name() const { return parts_->name; }
std::span<const Vec3f> Mesh::positions() const { return parts_->arrays.positions; }
std::span<const Vec3f> Mesh::normals() const { return parts_->arrays.normals; }
std::span<const Triangle> Mesh::triangles() const { return parts_->arrays.triangles; }
MeshData Mesh::data() const { return {parts_->arrays.positions, parts_->arrays.triangles}; }
const MeshTraits& Mesh::traits() const { return parts_->traits; }
const MeshView& Mesh::view() const { return parts_->view; }

}  // namespace pierce
