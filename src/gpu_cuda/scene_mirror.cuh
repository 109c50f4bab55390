#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "core/base/places.hpp"
#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "gpu_cuda/body_changes.cuh"
#include "gpu_cuda/cuda_executor.cuh"
#include "gpu_cuda/mesh_mirror.cuh"
#include "gpu_cuda/place_mirror.cuh"

namespace pierce::cuda {

/// A scene in device memory. All of it is copied once per plan, and in every step what the host has
/// changed. Where a new plan differs by the meshes of a few bodies alone, only these are copied:
/// all else keeps its place and its size, so that captured steps stay valid.
class SceneMirror {
public:
    explicit SceneMirror(CudaExecutor& executor)
        : executor_(executor), meshes_(executor), places_(executor) {}

    enum class Change { none, meshes, all };

    /// Brings the mirror up to date. Returns what is new besides where bodies are.
    Change update(const Scene& host) {
        Change change = Change::none;
        if (plan_.revision != host.plan->revision) {
            meshes_.settle();
            change = follow(host) ? Change::meshes : Change::all;
            if (change == Change::all) rebuild(host);
            plan_ = *host.plan;
        }
        scene_.plan = host.plan;
        scene_.part = host.part;
        places_.send(change == Change::all ? as_changed(host) : host, view_of(bodies_));
        if (change == Change::all || sent_forgets_ != host.forgets_sides[0]) {
            sent_forgets_ = host.forgets_sides[0];
            executor_.upload(std::span<const std::uint32_t>(&sent_forgets_, 1), forgets_);
        }
        scene_.forgets_sides = view_of(std::as_const(forgets_));
        return change;
    }

    /// The scene for a step on the device.
    const Scene& scene() const { return scene_; }

    /// Copies what the device found out about where bodies are into the host's views.
    void fetch(View<BodyView> host) const {
        std::vector<BodyView> there(bodies_.size());
        executor_.copy_to_host(there.data(), bodies_.data(), there.size());
        executor_.wait();
        for (std::uint32_t b = 0; b < host.size && b < there.size(); ++b) {
            static_cast<BodyBounds&>(host[b]) = there[b];
            host[b].space = there[b].space;
            host[b].active = there[b].active;
        }
    }

    /// Copies deforming bodies' shapes of the last step into the host's, for bodies that still
    /// exist.
    void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> host) const {
        for (std::uint32_t b = 0; b < host.size && b < known_.size(); ++b)
            if (known_[b].id == ids[b] && known_[b].seen == host[b].size)
                executor_.copy_to_host(host[b].data, seen_.data() + patches_at_.first(b),
                                       host[b].size);
        executor_.wait();
    }

    /// Keeps the shapes of the last step, which a step overwrites, on the device.
    void keep_seen() {
        kept_seen_.resize(seen_.size());
        executor_.copy(kept_seen_.data(), seen_.data(), seen_.size(), cudaMemcpyDeviceToDevice);
    }
    /// The shapes of the last step are again those that were kept.
    void restore_seen() {
        executor_.copy(seen_.data(), kept_seen_.data(), seen_.size(), cudaMemcpyDeviceToDevice);
    }

private:
    // Where meshes change, a share of every array is kept free for bodies that grow.
    static constexpr std::uint32_t spare_share = 4, spare_items = 256;
    // If more than a share of the bodies change, everything is copied.
    static constexpr std::uint32_t most_changed_share = 4;

    /// What the mirror has of a body.
    struct Known {
        BodyId id;
        std::uint64_t mesh_key = 0;
        Motion motion = Motion::fixed;
        Collision collision;
        Filter filter;
        std::uint32_t world_place = 0, part = 0;
        double range = 0;
        std::uint32_t seen = 0;  ///< patches whose shape of the last step is kept

        bool is_same(const BodyView& body) const {
            return mesh_key == body.mesh_key && collision == body.collision &&
                   filter == body.filter && world_place == body.world_place && part == body.part &&
                   range == body.range;
        }
    };

    static std::uint32_t with_room(std::uint32_t count, bool grows) {
        return grows && count > 0 ? count + count / spare_share + spare_items : count;
    }

    /// The scene as if all bodies had changed.
    Scene as_changed(const Scene& host) {
        all_bodies_.clear();
        for (std::uint32_t b = 0; b < host.bodies.size; ++b)
            if (host.ids[b]) all_bodies_.push_back(b);
        Scene all = host;
        all.changed = pierce::view_of(std::as_const(all_bodies_));
        return all;
    }

    /// Copies only the bodies that have changed; false if that cannot be done.
    bool follow(const Scene& host) {
        if (known_.size() != host.bodies.size || !plan_.steps_like(*host.plan)) return false;
        std::vector<std::uint32_t> changed;
        for (std::uint32_t b = 0; b < host.bodies.size; ++b) {
            if (known_[b].id != host.ids[b] || known_[b].motion != host.bodies[b].motion)
                return false;
            if (!known_[b].is_same(host.bodies[b])) changed.push_back(b);
        }
        meshes_change_ = true;
        if (!has_room_ || changed.size() * most_changed_share > known_.size()) return false;
        if (!std::ranges::all_of(changed,
                                 [&](std::uint32_t b) { return meshes_.can_add(host.bodies[b]); }))
            return false;
        bool items_differ = false;
        for (std::uint32_t b : changed)
            if (host.bodies[b].motion == Motion::deforming) {
                const BodyView& body = host.bodies[b];
                // Those of ghosts come last.
                items_differ = items_differ || body.patches.size != patches_at_.size(b) ||
                               body.box_nodes.size != nodes_at_.size(b) ||
                               body.part != known_[b].part;
                if (!places_.vertices().resize(b, body.positions.size) ||
                    !blocks_at_.resize(b, body.blocks.size) ||
                    !patches_at_.resize(b, body.patches.size) ||
                    !nodes_at_.resize(b, body.box_nodes.size))
                    return false;
            }
        if (items_differ && !send_items(host)) return false;
        meshes_.forget_unused(host.bodies);
        replace(host, changed);
        send_filters(host);
        return true;
    }

    /// Copies the lists of items again; false if they have outgrown their room.
    bool send_items(const Scene& host) {
        if (host.block_items.size > block_items_.size()) return false;
        // Captured steps wait for ghosts only after as many blocks.
        if (host.ghost_blocks > 0 && host.own_blocks() < scene_.own_blocks()) return false;
        for (std::uint32_t level = 0; level < BoxLevels::most; ++level)
            if (host.level_begin[level + 1] - host.level_begin[level] >
                scene_.level_begin[level + 1] - scene_.level_begin[level])
                return false;
        copy_items(host);
        return true;
    }

    /// Copies which pairs are excluded, and where worlds begin. As long as there are as many, the
    /// lists keep their places.
    void send_filters(const Scene& host) {
        executor_.upload(std::span<const Pair>(host.excluded.begin(), host.excluded.end()),
                         excluded_);
        executor_.upload(
            std::span<const std::uint32_t>(host.world_begins.begin(), host.world_begins.end()),
            world_begins_);
    }

    void copy_items(const Scene& host) {
        BlockItem* const blocks = staged_blocks_.resize(block_items_.size());
        std::fill(std::copy(host.block_items.begin(), host.block_items.end(), blocks),
                  blocks + block_items_.size(), BlockItem{});
        executor_.copy(block_items_.data(), blocks, block_items_.size(), cudaMemcpyHostToDevice);
        NodeItem* const nodes = staged_nodes_.resize(node_items_.size());
        for (std::uint32_t level = 0; level < BoxLevels::most; ++level) {
            const NodeItem* const items = host.node_items.data;
            std::fill(
                std::copy(items + host.level_begin[level], items + host.level_begin[level + 1],
                          nodes + scene_.level_begin[level]),
                nodes + scene_.level_begin[level + 1], NodeItem{});
        }
        executor_.copy(node_items_.data(), nodes, node_items_.size(), cudaMemcpyHostToDevice);
        BlockRange* const ranges = staged_ranges_.resize(host.ranges.size);
        std::copy(host.ranges.begin(), host.ranges.end(), ranges);
        executor_.copy(ranges_.data(), ranges, host.ranges.size, cudaMemcpyHostToDevice);
    }

    void replace(const Scene& host, std::span<const std::uint32_t> bodies) {
        // A mesh is there with all that some body needs of it before a body looks at it.
        for (const std::uint32_t b : bodies) meshes_.add(host.bodies[b]);
        ChangedBody* const changed = staged_changes_.resize(bodies.size());
        for (std::size_t k = 0; k < bodies.size(); ++k) {
            const std::uint32_t b = bodies[k];
            const std::uint32_t seen_before = known_[b].seen;
            changed[k] = place(host, b);
            // Where the sizes agree, the step compares with the last shape.
            if (known_[b].seen != seen_before)
                executor_.copy(seen_.data() + patches_at_.first(b), host.seen[b].data,
                               host.seen[b].size, cudaMemcpyHostToDevice);
        }
        changes_.resize(static_cast<std::uint32_t>(bodies.size()));
        executor_.copy(changes_.data(), changed, bodies.size(), cudaMemcpyHostToDevice);
        executor_.for_each(changes_.count(),
                           ReplaceBody{.changed = view_of(std::as_const(changes_)),
                                       .bodies = view_of(bodies_),
                                       .blocks = view_of(block_views_),
                                       .patches = view_of(patch_views_),
                                       .seen = view_of(seen_views_),
                                       .box_nodes = view_of(node_views_)});
    }

    /// A body with views of device memory; notes what the mirror knows of it.
    ChangedBody place(const Scene& host, std::uint32_t b) {
        ChangedBody now;
        now.body = b;
        BodyView& view = now.view = host.bodies[b];
        known_[b] = {.id = host.ids[b],
                     .mesh_key = view.mesh_key,
                     .motion = view.motion,
                     .collision = view.collision,
                     .filter = view.filter,
                     .world_place = view.world_place,
                     .part = view.part,
                     .range = view.range,
                     .seen = host.seen[b].size};
        if (view.mesh_key == 0) {
            places_.place(b, view);
            return now;
        }
        view.mesh = meshes_.view_of(host.bodies[b]);
        if (view.motion == Motion::deforming) {
            view.blocks = now.blocks = {blocks_.data() + blocks_at_.first(b), view.blocks.size};
            view.patches = now.patches = {patches_.data() + patches_at_.first(b),
                                          view.patches.size};
            view.box_nodes = now.box_nodes = {box_nodes_.data() + nodes_at_.first(b),
                                              view.box_nodes.size};
            now.seen = {seen_.data() + patches_at_.first(b), host.seen[b].size};
        } else {
            view.positions = view.mesh.positions;
            view.blocks = view.mesh.blocks;
            view.patches = view.mesh.patches;
            view.box_nodes = view.mesh.box_nodes;
        }
        places_.place(b, view);
        return now;
    }

    /// Lays out, for all deforming bodies, items of which they have size(body).
    template <class Size>
    std::uint32_t lay_out(View<const BodyView> bodies, Places& places, const Size& size) {
        std::vector<std::uint32_t> sizes(bodies.size, 0);
        std::uint32_t all = 0;
        for (std::uint32_t b = 0; b < bodies.size; ++b)
            if (bodies[b].motion == Motion::deforming) all += sizes[b] = size(bodies[b]);
        places.lay_out(sizes, with_room(all, meshes_change_) - all);
        return places.room();
    }

    void rebuild(const Scene& host) {
        executor_.wait();
        fetch_seen(host.ids, host.seen);
        has_room_ = meshes_change_;
        const auto count = [&](auto member) {
            return [member](const BodyView& body) { return (body.*member).size; };
        };
        lay_out(host.bodies, places_.vertices(), count(&BodyView::positions));
        places_.rebuild(host.bodies.size, host.plan->sheets);
        blocks_.resize(lay_out(host.bodies, blocks_at_, count(&BodyView::blocks)));
        patches_.resize(lay_out(host.bodies, patches_at_, count(&BodyView::patches)));
        box_nodes_.resize(lay_out(host.bodies, nodes_at_, count(&BodyView::box_nodes)));
        seen_.resize(host.plan->remembers() ? patches_at_.room() : 0);
        for (std::uint32_t b = 0; b < host.seen.size; ++b)
            executor_.copy(seen_.data() + patches_at_.first(b), host.seen[b].data,
                           host.seen[b].size, cudaMemcpyHostToDevice);

        meshes_.forget_unused(host.bodies);
        for (const BodyView& body : host.bodies)
            if (body.mesh_key != 0) meshes_.add(body);
        known_.assign(host.bodies.size, {});
        std::vector<BodyView> views;
        std::vector<View<PatchBlock>> block_views;
        std::vector<View<Offsets>> patch_views;
        std::vector<View<BoxNode>> node_views;
        std::vector<View<SeenPatch>> seen_views;
        for (std::uint32_t b = 0; b < host.bodies.size; ++b) {
            const ChangedBody placed = place(host, b);
            views.push_back(placed.view);
            block_views.push_back(placed.blocks);
            patch_views.push_back(placed.patches);
            node_views.push_back(placed.box_nodes);
            seen_views.push_back(placed.seen);
        }
        executor_.upload(std::span<const BodyView>(views), bodies_);
        executor_.upload(std::span<const View<PatchBlock>>(block_views), block_views_);
        executor_.upload(std::span<const View<Offsets>>(patch_views), patch_views_);
        executor_.upload(std::span<const View<BoxNode>>(node_views), node_views_);
        executor_.upload(std::span<const View<SeenPatch>>(seen_views), seen_views_);
        executor_.upload(std::span<const BodyId>(host.ids.begin(), host.ids.end()), ids_);
        send_filters(host);
        block_items_.resize(with_room(host.block_items.size, meshes_change_));
        ranges_.resize(host.ranges.size);
        LevelBegins level_begin{};
        for (std::uint32_t level = 0; level < BoxLevels::most; ++level)
            level_begin[level + 1] = level_begin[level] + with_room(host.level_begin[level + 1] -
                                                                        host.level_begin[level],
                                                                    meshes_change_);
        node_items_.resize(level_begin[BoxLevels::most]);
        scene_ = {.bodies = view_of(bodies_),
                  .ids = view_of(std::as_const(ids_)),
                  .changed = {},
                  .excluded = view_of(std::as_const(excluded_)),
                  .world_begins = view_of(std::as_const(world_begins_)),
                  .block_items = view_of(std::as_const(block_items_)),
                  .ghost_blocks = host.ghost_blocks == 0
                                      ? 0
                                      : view_of(block_items_).size - host.own_blocks(),
                  .ranges = view_of(std::as_const(ranges_)),
                  .blocks = view_of(std::as_const(block_views_)),
                  .patches = view_of(std::as_const(patch_views_)),
                  .seen = view_of(std::as_const(seen_views_)),
                  .node_items = view_of(std::as_const(node_items_)),
                  .level_begin = level_begin,
                  .box_nodes = view_of(std::as_const(node_views_)),
                  .plan = host.plan,
                  .meshes_change = meshes_change_,
                  .forgets_sides = view_of(std::as_const(forgets_))};
        copy_items(host);
    }

    CudaExecutor& executor_;
    Plan plan_;  ///< of the last step
    Scene scene_;
    bool meshes_change_ = false;  ///< a body has got another mesh
    bool has_room_ = false;       ///< for bodies that grow
    MeshMirror meshes_;
    std::vector<std::uint32_t> all_bodies_;
    std::vector<Known> known_;  ///< per body, like the next ones
    PlaceMirror places_;
    Places blocks_at_, patches_at_, nodes_at_;
    StagingBuffer<ChangedBody> staged_changes_;
    StagingBuffer<BlockItem> staged_blocks_;
    StagingBuffer<NodeItem> staged_nodes_;
    StagingBuffer<BlockRange> staged_ranges_;
    std::uint32_t sent_forgets_ = 0;
    DeviceBuffer<std::uint32_t> forgets_;
    DeviceBuffer<BodyView> bodies_;
    DeviceBuffer<ChangedBody> changes_;
    DeviceBuffer<PatchBlock> blocks_;
    DeviceBuffer<Offsets> patches_;
    DeviceBuffer<BoxNode> box_nodes_;
    DeviceBuffer<SeenPatch> seen_, kept_seen_;
    DeviceBuffer<View<PatchBlock>> block_views_;
    DeviceBuffer<View<Offsets>> patch_views_;
    DeviceBuffer<View<BoxNode>> node_views_;
    DeviceBuffer<View<SeenPatch>> seen_views_;
    DeviceBuffer<BodyId> ids_;
    DeviceBuffer<Pair> excluded_;
    DeviceBuffer<std::uint32_t> world_begins_;
    DeviceBuffer<BlockItem> block_items_;
    DeviceBuffer<BlockRange> ranges_;
    DeviceBuffer<NodeItem> node_items_;
};

}  // namespace pierce::cuda
