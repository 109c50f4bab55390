#pragma once

#include <algorithm>
#include <map>
#include <span>
#include <vector>

#include "core/base/places.hpp"
#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "gpu_cuda/body_changes.cuh"
#include "gpu_cuda/cuda_executor.cuh"
#include "gpu_cuda/device_buffer.hpp"
#include "gpu_cuda/far_positions.cuh"

namespace pierce::cuda {

/// Where bodies are, in device memory: what the host has changed is sent in every step, and poses
/// that the caller keeps on the device are read there.
class PlaceMirror {
public:
    explicit PlaceMirror(CudaExecutor& executor) : executor_(executor) {
        executor_.expect_ghosts(far_.done());
    }

    /// Where the vertices of deforming bodies are kept.
    Places& vertices() { return vertices_at_; }
    /// To be called when vertices() was laid out anew; place() follows for every body.
    void rebuild(std::uint32_t bodies, bool has_starts) {
        positions_.resize(vertices_at_.room());
        starts_.resize(has_starts ? vertices_at_.room() : 0);
        sent_version_.assign(bodies, 0);
        positions_of_.assign(bodies, nullptr);
        takes_part_.clear();
        posed_.clear();
        far_.clear();
    }
    /// Sets where the device has a body's vertices, which are to be sent. The body's mesh is there.
    void place(std::uint32_t b, BodyView& view) {
        if (view.motion == Motion::deforming) {
            view.positions = {positions_.data() + vertices_at_.first(b), view.positions.size};
            view.start = {starts_.data() + vertices_at_.first(b), view.start.size};
            // Bodies that take no part are not sent, but their trees are built.
            if (!view.active)
                executor_.copy(positions_.data() + vertices_at_.first(b), view.mesh.positions.data,
                               view.positions.size, cudaMemcpyDeviceToDevice);
        }
        positions_of_[b] = view.positions.data;
        sent_version_[b] = 0;
    }

    /// Sends where the bodies are that have changed, and their positions.
    void send(const Scene& host, View<BodyView> bodies) {
        list_far(host);
        // They come beside all that follows, until the step waits for ghosts.
        far_.fetch(executor_.stream());
        if (host.changed.size > 0) {
            send_positions(host);
            PlacedBody* const staged = staged_inputs_.resize(host.changed.size);
            for (std::uint32_t k = 0; k < host.changed.size; ++k) {
                const std::uint32_t b = host.changed[k];
                staged[k] = {b, host.bodies[b]};
                BodyInput& input = staged[k].input;
                input.positions.data = positions_of_[b];
                input.start.data = starts_.data() + vertices_at_.first(b);
                if (input.device_positions != nullptr && !far_.has(b)) {
                    input.positions.data = input.device_positions;
                    input.start.data = input.device_start;
                }
            }
            // The last step is over, so that nothing reads the inputs any more.
            inputs_.resize(host.changed.size);
            executor_.copy(inputs_.data(), staged, host.changed.size, cudaMemcpyHostToDevice);
            executor_.for_each(host.changed.size,
                               ApplyInput{view_of(std::as_const(inputs_)), bodies});
            list_posed(host);
        }
        executor_.for_each(posed_.count(), ReadPose{view_of(std::as_const(posed_)), bodies});
    }

private:
    /// Sends the positions that have changed, with one copy for bodies that follow each other.
    void send_positions(const Scene& host) {
        std::vector<std::uint32_t> wanted;
        std::size_t vertices = 0;
        for (const std::uint32_t b : host.changed) {
            const BodyView& body = host.bodies[b];
            if (body.motion != Motion::deforming || body.device_positions != nullptr ||
                !body.active || sent_version_[b] == body.positions_version)
                continue;
            sent_version_[b] = body.positions_version;
            wanted.push_back(b);
            vertices += body.positions.size;
        }
        if (wanted.empty()) return;
        const bool has_starts = starts_.size() > 0;
        Vec3f* const staged = staged_positions_.resize((has_starts ? 2 : 1) * vertices);
        const auto send = [&](Vec3f* from, Vec3f* to, View<const Vec3f> BodyInput::*member) {
            std::size_t run = 0, end = 0;       // of what was staged and not yet copied
            std::uint32_t first = 0, next = 0;  // its places on the device
            const auto flush = [&] {
                executor_.copy(to + first, from + run, end - run, cudaMemcpyHostToDevice);
                run = end;
            };
            for (const std::uint32_t b : wanted) {
                const View<const Vec3f> positions = host.bodies[b].*member;
                if (vertices_at_.first(b) != next) {
                    flush();
                    first = vertices_at_.first(b);
                }
                std::copy(positions.begin(), positions.end(), from + end);
                end += positions.size;
                next = vertices_at_.first(b) + positions.size;
            }
            flush();
        };
        send(staged, positions_.data(), &BodyInput::positions);
        if (has_starts) send(staged + vertices, starts_.data(), &BodyInput::start);
    }

    /// Lists the bodies that take part and have their positions on another device.
    void list_far(const Scene& host) {
        for (const std::uint32_t b : host.changed) {
            const BodyView& body = host.bodies[b];
            if (!body.active || !is_far(body)) {
                far_.remove(b);
                continue;
            }
            far_.add(b, {.is_ghost = host.ghost_blocks > 0 && body.part != host.part,
                         .from = body.device_positions,
                         .start_from = starts_.size() > 0 ? body.device_start : nullptr,
                         .to = positions_.data() + vertices_at_.first(b),
                         .start_to = starts_.data() + vertices_at_.first(b),
                         .count = body.positions.size});
        }
    }

    /// Lists the bodies whose poses are in device memory, where that may have changed.
    void list_posed(const Scene& host) {
        bool differs = false;
        for (const std::uint32_t b : host.changed) {
            if (takes_part_.erase(b) > 0) differs = true;
            if (!host.bodies[b].device_pose.exists()) continue;
            takes_part_[b] = host.bodies[b].active;
            differs = true;
        }
        if (!differs) return;
        std::vector<PosedBody> posed;
        for (const auto& [body, takes_part] : takes_part_) posed.push_back({body, takes_part});
        executor_.upload(std::span<const PosedBody>(posed), posed_);
    }

    CudaExecutor& executor_;
    Places vertices_at_;
    std::vector<std::uint64_t> sent_version_;   ///< per body, like the next one
    std::vector<const Vec3f*> positions_of_;    ///< on the device
    std::map<std::uint32_t, bool> takes_part_;  ///< by body, if its pose is in device memory
    StagingBuffer<PlacedBody> staged_inputs_;
    StagingBuffer<Vec3f> staged_positions_;
    DeviceBuffer<PlacedBody> inputs_;
    DeviceBuffer<PosedBody> posed_;
    FarPositions far_;
    DeviceBuffer<Vec3f> positions_, starts_;
};

}  // namespace pierce::cuda
