#include "pierce/mesh.hpp"

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>
#include <utility>

#include "core/base/for_now.hpp"
#include "core/base/usable.hpp"
#include "core/base/workers.hpp"
#include "core/device/view.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/edge_group.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/patch.hpp"
#include "core/mesh/used_vertices.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "core/mesh_build/closed_surface.hpp"
#include "core/mesh_build/kept_order.hpp"
#include "core/mesh_build/leaves.hpp"
#include "core/mesh_build/mesh_cache.hpp"
#include "core/mesh_build/mesh_change.hpp"
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

constexpr std::size_t triangles_for_threads = 4096;

}  // namespace

void check_mesh_data(const std::string& name, const MeshData& data) {
    if (data.triangles.empty()) throw InputError("mesh '" + name + "' has no triangles");
    check_positions("mesh '" + name + "'", data.positions);
    for (std::size_t t = 0; t < data.triangles.size(); ++t)
        for (std::uint32_t v : data.triangles[t].vertex)
            if (v >= data.positions.size())
                throw InputError("mesh '" + name + "': triangle " + std::to_string(t) +
                                 " names vertex " + std::to_string(v) + ", but there are " +
                                 std::to_string(data.positions.size()));
    Box box;
    for (const Vec3f p : data.positions) box.extend(to_double(p));
    if (is_too_small(box))
        throw InputError("mesh '" + name + "' is too small: it is less than 2^-60 across");
    if (std::max(data.positions.size(), 3 * data.triangles.size()) > constants::max_elements)
        throw InputError("mesh '" + name + "' has more than " +
                         std::to_string(constants::max_elements) + " vertices or corners");
}

/// What a Mesh owns. The arrays are filled one after the other. The code that fills one reads
/// earlier ones through `view`.
struct Mesh::Parts {
    std::string name;
    MeshOptions options;
    MeshTraits traits;
    MeshInside inside;
    std::vector<Triangle> given_triangles;  ///< empty if `arrays.triangles` are those
    std::vector<std::uint32_t> places;  ///< per triangle, its place among those that were given;
                                        ///< empty as above
    MeshArrays<MeshVector> arrays;
    MeshView view;
    MeshView first_view;  ///< without what is made later, so that it needs no lock
    std::optional<MeshCache> cache;
    bool is_cached = false;                    ///< the cache was asked
    bool is_changed = false;                   ///< it comes from another mesh
    std::unique_ptr<const MeshChange> change;  ///< from that mesh, until all is known that is taken
                                               ///< over
    std::mutex lock;                           ///< of what is made later
    std::atomic<std::thread::id> telling;      ///< the thread that calls `options.progress` now
    MeshNeeds made;

    Parts(std::string its_name, MeshData data, MeshOptions its_options, Parts* before);

    void make(const MeshNeeds& needs);

    /// Throws InputError for a progress callback that asks for what is being made.
    void check_not_telling() const {
        if (telling == std::this_thread::get_id())
            throw InputError("mesh '" + name +
                             "' is being measured: its progress callback cannot use it");
    }

private:
    Workers make_workers() {
        if (!options.progress) return Workers(options.threads);
        return Workers(options.threads, [this](std::string_view what, double share) {
            const ForNow now(telling, std::this_thread::get_id());
            options.progress(what, share);
        });
    }
    void see_arrays() {
        for_each_array([](auto& seen, const auto& owned) { seen = view_of(owned); }, view, arrays);
    }
    HalfEdges choose_triangles(MeshData& data, Workers& workers);
    void divide_into_patches(Workers& workers, Parts* before);
    void measure_boxes();
    void find_edges();
    void measure_patches(Parts* before);
    void make_clearance();
    void make_slabs(Workers& workers);
    void make_rings(Workers& workers);
};

Mesh::Parts::Parts(std::string its_name, MeshData data, MeshOptions its_options, Parts* before)
    : name(std::move(its_name)), options(std::move(its_options)) {
    check_mesh_data(name, data);
    if (options.inside > Inside::none)
        throw InputError("mesh '" + name + "': inside has a value without a meaning");
    if (!options.cache.empty()) cache.emplace(options.cache);
    // Starting a thread takes longer than a small mesh does.
    Workers workers(data.triangles.size() < triangles_for_threads ? 1 : options.threads,
                    options.progress);
    const std::vector<bool> used = used_vertices(data.triangles, data.positions.size());
    Vec3d sum;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v]) {
            view.box.extend(to_double(data.positions[v]));
            sum += to_double(data.positions[v]);
        }
    view.centroid = sum * (1.0 / static_cast<double>(std::ranges::count(used, true)));
    const HalfEdges sides = choose_triangles(data, workers);
    view.mean_edge_length = traits.mean_edge_length;
    view.closed = inside.exists();
    arrays.positions = std::move(data.positions);
    arrays.triangles = std::move(data.triangles);
    see_arrays();
    if (before != nullptr) {
        before->check_not_telling();
        const std::lock_guard guard(before->lock);
        change = std::make_unique<const MeshChange>(before->view, view);
    }
    if (change != nullptr && change->is_another_mesh()) change.reset();
    if (change == nullptr) before = nullptr;
    is_changed = change != nullptr;
    if (is_changed) cache.reset();
    made.slabs = is_changed;  // it goes without
    const std::vector<std::uint32_t> partner = before != nullptr
                                                   ? change->partners(view,
                                                                      before->first_view.leaves)
                                                   : std::vector<std::uint32_t>();
    workers.side_by_side(
        "edges",
        [&] {
            arrays.edges = edges_of(view, sides, workers,
                                    before != nullptr ? &before->first_view.edges : nullptr);
        },
        [&] {
            std::tie(arrays.corner_offsets, arrays.corners) = corners_by_vertex(
                arrays.triangles, arrays.positions.size());
            arrays.fans = fans_of(arrays.corner_offsets, arrays.corners);
            arrays.leaves = bvh::leaves_of(arrays.positions, arrays.triangles, sides, partner);
            arrays.neighbors = neighbors_of(arrays.triangles.size(), sides);
        });
    see_arrays();
    divide_into_patches(workers, before);
    see_arrays();
    workers.side_by_side(
        "boxes", [&] { measure_boxes(); }, [&] { find_edges(); }, [&] { measure_patches(before); });
    see_arrays();
    first_view = view;
}

/// Decides what is inside, and with which triangles. Returns their sides.
HalfEdges Mesh::Parts::choose_triangles(MeshData& data, Workers& workers) {
    HalfEdges sides(data.triangles, data.positions.size());
    traits = traits_of(data, sides, view.centroid);
    view.has_degenerate = traits.degenerate_triangles > 0;
    ClosedSurface surface = surface_with_inside(data, sides, traits, options.inside, workers);
    inside = surface.inside;
    arrays.covered = std::move(surface.covered);
    if (inside.rule != Inside::winding) return sides;
    given_triangles = std::exchange(data.triangles, std::move(surface.triangles));
    places = std::move(surface.given);
    sides = HalfEdges(data.triangles, data.positions.size());
    const MeshTraits of_surface = traits_of(data, sides, view.centroid);
    traits.volume = of_surface.volume;
    view.has_degenerate = of_surface.degenerate_triangles > 0;
    traits.mean_edge_length = of_surface.mean_edge_length;
    return sides;
}

void Mesh::Parts::divide_into_patches(Workers& workers, Parts* before) {
    std::vector<std::uint32_t> start_of_vertices, start_of_triangles;
    if (before != nullptr) {
        std::vector<std::uint32_t> vertices_now(before->first_view.positions.size, is_gone);
        for (const std::uint32_t v : before->arrays.patch_vertices)
            if (v < view.positions.size) vertices_now[v] = v;
        start_of_vertices = kept_order(before->arrays.patch_vertices, vertices_now,
                                       view.positions.size);
        start_of_triangles = kept_order(before->arrays.group_triangles, change->triangles_now(),
                                        view.triangles.size);
    }
    const std::vector<Vec3f>& points = arrays.positions;
    std::vector<Vec3f> middles;
    middles.reserve(arrays.triangles.size());
    for (const Triangle& t : arrays.triangles)
        middles.push_back(
            to_float((1.0 / 3) * (to_double(points[t.vertex[0]]) + to_double(points[t.vertex[1]]) +
                                  to_double(points[t.vertex[2]]))));
    arrays.patch_vertices = spatial_order(points, constants::patch_size, workers.threads(),
                                          start_of_vertices);
    std::erase_if(arrays.patch_vertices, [&](std::uint32_t v) { return !has_triangles(view, v); });
    arrays.group_triangles = spatial_order(middles, constants::group_size, workers.threads(),
                                           start_of_triangles);
}

void Mesh::Parts::measure_boxes() {
    const BoxLevels levels(view.triangles.size);
    arrays.box_nodes.resize(levels.nodes());
    for (std::uint32_t n = 0; n < levels.nodes(); ++n)
        measure_node(view, view.positions, levels, n, view_of(arrays.box_nodes));
}

void Mesh::Parts::find_edges() {
    arrays.edge_groups.resize(edge_group_count(view));
    arrays.edge_blocks.resize(edge_block_count(view));
    for (std::uint32_t b = 0; b < edge_block_count(view); ++b)
        measure_edge_block(view, b, arrays.edge_blocks[b], view_of(arrays.edge_groups));
    arrays.features = features_of(view);
}

void Mesh::Parts::measure_patches(Parts* before) {
    arrays.normals.reserve(arrays.positions.size());
    for (std::uint32_t v = 0; v < arrays.positions.size(); ++v)
        arrays.normals.push_back(before != nullptr && change->keeps_normal(v)
                                     ? before->arrays.normals[v]
                                     : to_float(vertex_normal(view, view.positions, v)));
    arrays.parts = parts_of(view);
    arrays.blocks.resize(block_count(view));
    arrays.patches.resize(patch_count(view));
    for (std::uint32_t p = 0; p < patch_count(view); ++p)
        measure_patch(view, view.positions, p, arrays.blocks[p / constants::block_size],
                      arrays.patches[p]);
    for (std::uint32_t b = 0; b < block_count(view); ++b)
        finish_block(view, view.positions, b, arrays.blocks[b]);
}

void Mesh::Parts::make(const MeshNeeds& needs) {
    // To ask for the machine's threads takes a system call.
    if (!view.closed || made.has(needs)) return;
    if (cache && !is_cached && needs != MeshNeeds{}) {
        made = cache->load(view, arrays, view);
        is_cached = true;
        see_arrays();
    }
    const MeshNeeds had = made;
    Workers workers = make_workers();
    // If memory runs out, what was made before is there as a whole.
    const auto make_once = [this](bool needed, bool& done, auto&& work) {
        if (!needed || done) return;
        work();
        see_arrays();
        done = true;
    };
    make_once(needs.clearance, made.clearance, [&] { make_clearance(); });
    make_once(needs.rings, made.rings, [&] { make_rings(workers); });
    make_once(needs.slabs, made.slabs, [&] { make_slabs(workers); });
    make_once(needs.stars, made.stars,
              [&] { arrays.star_clearance = star_clearance(view, workers, change.get()); });
    make_once(needs.own_exits, made.own_exits,
              [&] { arrays.own_exit = own_exits_of(view, workers); });
    if (made.clearance && made.rings) change.reset();
    if (cache && made != had) cache->store(view, made);
}

void Mesh::Parts::make_clearance() {
    ClearanceGrid clearance;
    if (!is_changed)
        clearance = build_clearance_grid(arrays.positions, arrays.triangles);
    else if (std::optional<ClearanceGrid> known = change->clearance())
        clearance = std::move(*known);
    arrays.clearance_steps = std::move(clearance.steps);
    view.clearance_at = clearance.layout;
}

void Mesh::Parts::make_rings(Workers& workers) {
    if (!arrays.covered.empty()) {
        // What is known of the triangles near a point says nothing about parts that lie around it.
        arrays.rings.resize(arrays.triangles.size());
        return;
    }
    arrays.rings = rings_of(view, workers, change.get());
    view.simple = traits.volume > 0 && arrays.parts.size() == 1 &&
                  std::ranges::all_of(arrays.rings, [](const TriangleRing& r) {
                      return r.gap > 0 && r.openness > 0;
                  });
}

void Mesh::Parts::make_slabs(Workers& workers) {
    const ClearanceGrid coarse = build_clearance_grid(arrays.positions, arrays.triangles,
                                                      slab_resolution(arrays.triangles.size()));
    SlabGrid slabs = build_slab_grid(coarse, arrays.positions, arrays.triangles, workers);
    view.slabs_at = coarse.layout;
    arrays.slab_cells = std::move(slabs.cells);
    arrays.slabs = std::move(slabs.slabs);
}

Mesh::Mesh(std::string name, MeshData data, MeshOptions options)
    : parts_(
          std::make_unique<Parts>(std::move(name), std::move(data), std::move(options), nullptr)) {}
Mesh::Mesh(std::string name, MeshData data, const Mesh& before, MeshOptions options)
    : parts_(std::make_unique<Parts>(std::move(name), std::move(data), std::move(options),
                                     before.parts_.get())) {}
Mesh::Mesh(Mesh&&) noexcept = default;
Mesh& Mesh::operator=(Mesh&&) noexcept = default;
Mesh::~Mesh() = default;

const std::string& Mesh::name() const { return parts_->name; }
std::span<const Vec3f> Mesh::positions() const { return parts_->arrays.positions; }
std::span<const Vec3f> Mesh::normals() const { return parts_->arrays.normals; }
std::span<const Triangle> Mesh::triangles() const { return parts_->arrays.triangles; }
std::uint32_t Mesh::given_triangle(std::uint32_t triangle) const {
    if (triangle >= parts_->arrays.triangles.size())
        throw InputError("mesh '" + name() + "' has no triangle " + std::to_string(triangle));
    return parts_->places.empty() ? triangle : parts_->places[triangle];
}
MeshData Mesh::data() const {
    return {parts_->arrays.positions,
            parts_->places.empty() ? parts_->arrays.triangles : parts_->given_triangles};
}
const MeshTraits& Mesh::traits() const { return parts_->traits; }
const MeshInside& Mesh::inside() const { return parts_->inside; }

MeshView Mesh::view() const { return view(MeshNeeds::all()); }

MeshView Mesh::view(const MeshNeeds& needs) const {
    if (needs == MeshNeeds{}) return parts_->first_view;
    parts_->check_not_telling();
    const std::lock_guard guard(parts_->lock);
    parts_->make(needs);
    // Steps must not depend on what others have needed.
    MeshView view = parts_->view;
    if (!needs.clearance) {
        view.clearance_steps = {};
        view.clearance_at = {};
    }
    if (!needs.slabs) {
        view.slab_cells = {};
        view.slabs = {};
        view.slabs_at = {};
    }
    if (!needs.rings) view.rings = {};
    if (!needs.stars) view.star_clearance = {};
    if (!needs.own_exits) view.own_exit = {};
    view.simple = view.simple && needs.rings;
    return view;
}

}  // namespace pierce
