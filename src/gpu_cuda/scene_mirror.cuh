#pragma once

#include <cstring>
#include <unordered_map>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "gpu_cuda/cuda_executor.cuh"

namespace pierce::cuda {

/// Copies, per body, where the caller has put it. The step itself finds out where deforming bodies
/// are.
struct ApplyInput {
    View<const BodyInput> inputs;
    View<BodyView> bodies;

    PIERCE_HD void operator()(std::uint32_t i) const {
        BodyView& body = bodies[i];
        static_cast<BodyInput&>(body) = inputs[i];
        if (body.motion != Motion::deforming && body.active) body.fit = body.space;
    }
};

/// A scene in device memory. All of it is copied once per plan, and in every step what the host has
/// changed.
class SceneMirror {
public:
    explicit SceneMirror(CudaExecutor& executor) : executor_(executor) {}

    /// Brings the mirror up to date; returns true if everything is new.
    bool update(const Scene& host) {
        const bool is_new = revision_ != host.plan->revision;
        if (is_new) rebuild(host);
        send_inputs(host.bodies);
        if (is_new || sent_forgets_ != host.forgets_sides[0]) {
            sent_forgets_ = host.forgets_sides[0];
            executor_.upload(std::span<const std::uint32_t>(&sent_forgets_, 1), forgets_);
        }
        scene_.forgets_sides = view_of(std::as_const(forgets_));
        return is_new;
    }

    /// The scene for a step on the device.
    const Scene& scene() const { return scene_; }

    /// Copies what the device found out about where bodies are into the host's views.
    void fetch(View<BodyView> host) const {
        std::vector<BodyView> there(bodies_.size());
        executor_.copy_to_host(there.data(), bodies_.data(), there.size());
        executor_.wait();
        for (std::uint32_t b = 0; b < host.size; ++b) static_cast<BodyBounds&>(host[b]) = there[b];
    }

    /// Copies deforming bodies' shapes of the last step into the host's, for bodies that still
    /// exist.
    void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> host) const {
        for (std::uint32_t b = 0; b < host.size && b < seen_of_body_.size(); ++b) {
            const SeenOfBody& known = seen_of_body_[b];
            if (known.id == ids[b] && known.count == host[b].size)
                executor_.copy_to_host(host[b].data, seen_.data() + known.first, known.count);
        }
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
    /// Where a body's shape of the last step is kept, in seen_.
    struct SeenOfBody {
        BodyId id;
        std::uint32_t first = 0, count = 0;
    };

    /// Device copies of arrays that do not change.
    class Arrays {
    public:
        template <class T>
        View<const T> add(CudaExecutor& executor, View<const T> host) {
            DeviceBuffer<std::byte> copy;
            copy.resize(static_cast<std::uint32_t>(host.size * sizeof(T)));
            executor.copy(reinterpret_cast<T*>(copy.data()), host.data, host.size,
                          cudaMemcpyHostToDevice);
            buffers_.push_back(std::move(copy));
            return {reinterpret_cast<const T*>(buffers_.back().data()), host.size};
        }

    private:
        std::vector<DeviceBuffer<std::byte>> buffers_;
    };

    struct MeshCopy {
        Arrays arrays;
        MeshArrays<ConstView> on_host, on_device;
    };

    /// A body's mesh on the device.
    MeshView copy_of(const BodyView& body) {
        MeshCopy& copy = meshes_[body.mesh_key];
        MeshView view;
        static_cast<MeshShape&>(view) = body.mesh;
        // Plans, and bodies of one plan, differ in which arrays they need.
        for_each_array(
            [&](auto& seen, auto& on_device, auto& on_host, const auto& host) {
                if (host.size == 0) return;
                if (on_host.data != host.data || on_host.size != host.size) {
                    on_device = copy.arrays.add(executor_, host);
                    on_host = host;
                }
                seen = on_device;
            },
            view, copy.on_device, copy.on_host, body.mesh);
        return view;
    }

    void forget_unused(View<const BodyView> bodies) {
        std::unordered_map<std::uint64_t, bool> used;
        for (const BodyView& body : bodies) used[body.mesh_key] = true;
        std::erase_if(meshes_, [&](const auto& entry) { return !used.contains(entry.first); });
    }

    void rebuild(const Scene& host) {
        executor_.wait();
        fetch_seen(host.ids, host.seen);
        forget_unused(host.bodies);
        std::uint32_t vertices = 0, blocks = 0, patches = 0, nodes = 0;
        first_vertex_.assign(host.bodies.size, 0);
        for (std::uint32_t b = 0; b < host.bodies.size; ++b) {
            if (host.bodies[b].motion != Motion::deforming) continue;
            first_vertex_[b] = vertices;
            vertices += host.bodies[b].positions.size;
            blocks += host.bodies[b].blocks.size;
            patches += host.bodies[b].patches.size;
            nodes += host.bodies[b].box_nodes.size;
        }
        std::vector<SeenPatch> shapes;
        seen_of_body_.assign(host.bodies.size, {});
        for (std::uint32_t b = 0; b < host.bodies.size; ++b) {
            seen_of_body_[b] = {host.ids[b], static_cast<std::uint32_t>(shapes.size()),
                                host.seen[b].size};
            shapes.insert(shapes.end(), host.seen[b].begin(), host.seen[b].end());
        }
        positions_.resize(vertices);
        starts_.resize(host.plan->sheets ? vertices : 0);
        blocks_.resize(blocks);
        patches_.resize(patches);
        box_nodes_.resize(nodes);
        executor_.upload(std::span<const SeenPatch>(shapes), seen_);

        std::vector<BodyView> views(host.bodies.begin(), host.bodies.end());
        std::vector<View<PatchBlock>> block_views(views.size());
        std::vector<View<Offsets>> patch_views(views.size());
        std::vector<View<BoxNode>> node_views(views.size());
        std::vector<View<SeenPatch>> seen_views(views.size());
        PatchBlock* next_block = blocks_.data();
        Offsets* next_patch = patches_.data();
        BoxNode* next_node = box_nodes_.data();
        SeenPatch* next_seen = seen_.data();
        for (std::uint32_t b = 0; b < views.size(); ++b) {
            BodyView& view = views[b];
            if (view.mesh_key == 0) continue;
            view.mesh = copy_of(view);
            if (view.motion == Motion::deforming) {
                view.positions = {positions_.data() + first_vertex_[b], view.positions.size};
                view.start = {starts_.data() + first_vertex_[b], view.start.size};
                view.blocks = block_views[b] = {next_block, view.blocks.size};
                view.patches = patch_views[b] = {next_patch, view.patches.size};
                view.box_nodes = node_views[b] = {next_node, view.box_nodes.size};
                seen_views[b] = {next_seen, host.seen[b].size};
                next_block += view.blocks.size;
                next_patch += view.patches.size;
                next_node += view.box_nodes.size;
                next_seen += host.seen[b].size;
            } else {
                view.positions = view.mesh.positions;
                view.blocks = view.mesh.blocks;
                view.patches = view.mesh.patches;
                view.box_nodes = view.mesh.box_nodes;
            }
        }
        executor_.upload(std::span<const BodyView>(views), bodies_);
        executor_.upload(std::span<const View<PatchBlock>>(block_views), block_views_);
        executor_.upload(std::span<const View<Offsets>>(patch_views), patch_views_);
        executor_.upload(std::span<const View<BoxNode>>(node_views), node_views_);
        executor_.upload(std::span<const View<SeenPatch>>(seen_views), seen_views_);
        executor_.upload(std::span<const NodeItem>(host.node_items.begin(), host.node_items.end()),
                         node_items_);
        executor_.upload(std::span<const BodyId>(host.ids.begin(), host.ids.end()), ids_);
        executor_.upload(
            std::span<const BlockItem>(host.block_items.begin(), host.block_items.end()),
            block_items_);
        executor_.upload(std::span<const BlockRange>(host.ranges.begin(), host.ranges.end()),
                         ranges_);
        positions_of_.resize(views.size());
        for (std::uint32_t b = 0; b < views.size(); ++b) positions_of_[b] = views[b].positions.data;
        sent_version_.assign(host.bodies.size, 0);
        revision_ = host.plan->revision;
        scene_ = {.bodies = view_of(bodies_),
                  .ids = view_of(std::as_const(ids_)),
                  .block_items = view_of(std::as_const(block_items_)),
                  .ranges = view_of(std::as_const(ranges_)),
                  .blocks = view_of(std::as_const(block_views_)),
                  .patches = view_of(std::as_const(patch_views_)),
                  .seen = view_of(std::as_const(seen_views_)),
                  .node_items = view_of(std::as_const(node_items_)),
                  .level_begin = host.level_begin,
                  .box_nodes = view_of(std::as_const(node_views_)),
                  .plan = host.plan,
                  .forgets_sides = view_of(std::as_const(forgets_))};
    }

    void send_inputs(View<const BodyView> host) {
        BodyInput* const staged = staged_inputs_.resize(host.size);
        for (std::uint32_t b = 0; b < host.size; ++b) {
            BodyInput& input = staged[b] = host[b];
            input.positions.data = positions_of_[b];
            input.start.data = starts_.data() + first_vertex_[b];
            if (host[b].device_positions != nullptr) {
                input.positions.data = host[b].device_positions;
                input.start.data = host[b].device_start;
                continue;
            }
            if (host[b].motion != Motion::deforming ||
                sent_version_[b] == host[b].positions_version)
                continue;
            sent_version_[b] = host[b].positions_version;
            if (!host[b].active) continue;
            executor_.copy(positions_.data() + first_vertex_[b], host[b].positions.data,
                           host[b].positions.size, cudaMemcpyHostToDevice);
            executor_.copy(starts_.data() + first_vertex_[b], host[b].start.data,
                           host[b].start.size, cudaMemcpyHostToDevice);
        }
        // The last step is over, so that nothing reads the inputs any more.
        inputs_.resize(host.size);
        executor_.copy(inputs_.data(), staged, host.size, cudaMemcpyHostToDevice);
        executor_.for_each(host.size, ApplyInput{view_of(inputs_), view_of(bodies_)});
    }

    CudaExecutor& executor_;
    std::uint64_t revision_ = 0;
    Scene scene_;
    std::unordered_map<std::uint64_t, MeshCopy> meshes_;  ///< by mesh key
    std::vector<std::uint32_t> first_vertex_;             ///< per deforming body, in positions_
    std::vector<SeenOfBody> seen_of_body_;
    std::vector<std::uint64_t> sent_version_;
    StagingBuffer<BodyInput> staged_inputs_;
    std::vector<const Vec3f*> positions_of_;  ///< per body, on the device
    std::uint32_t sent_forgets_ = 0;
    DeviceBuffer<std::uint32_t> forgets_;
    DeviceBuffer<BodyInput> inputs_;
    DeviceBuffer<BodyView> bodies_;
    DeviceBuffer<Vec3f> positions_, starts_;
    DeviceBuffer<PatchBlock> blocks_;
    DeviceBuffer<Offsets> patches_;
    DeviceBuffer<BoxNode> box_nodes_;
    DeviceBuffer<SeenPatch> seen_, kept_seen_;
    DeviceBuffer<View<PatchBlock>> block_views_;
    DeviceBuffer<View<Offsets>> patch_views_;
    DeviceBuffer<View<BoxNode>> node_views_;
    DeviceBuffer<View<SeenPatch>> seen_views_;
    DeviceBuffer<BodyId> ids_;
    DeviceBuffer<BlockItem> block_items_;
    DeviceBuffer<BlockRange> ranges_;
    DeviceBuffer<NodeItem> node_items_;
};

}  // namespace pierce::cuda
