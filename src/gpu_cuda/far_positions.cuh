#pragma once

#include <cuda_runtime.h>

#include <map>
#include <utility>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "gpu_cuda/cuda_check.hpp"
#include "gpu_cuda/device_buffer.hpp"
#include "gpu_cuda/device_copy.hpp"
#include "gpu_cuda/on_device.hpp"

namespace pierce::cuda {

/// A body whose positions are in the memory of another device.
struct FarBody {
    bool is_ghost = false;  ///< the step may wait for its positions
    const Vec3f* from = nullptr;
    const Vec3f* start_from = nullptr;  ///< null: nobody needs them
    Vec3f* to = nullptr;
    Vec3f* start_to = nullptr;
    std::uint32_t count = 0;
};

/// True if a body's positions are in the memory of another device.
inline bool is_far(const BodyInput& body) {
    if (body.device_positions == nullptr) return false;
    cudaPointerAttributes where;
    check(cudaPointerGetAttributes(&where, body.device_positions), "where positions are");
    return where.type == cudaMemoryTypeDevice && where.device != current_device();
}

inline constexpr unsigned far_threads = 128;

/// A block per such body: copies its positions.
inline __global__ void copy_far_positions(View<const FarBody> far) {
    const FarBody body = far[blockIdx.x];
    for (std::uint32_t v = threadIdx.x; v < body.count; v += blockDim.x) {
        body.to[v] = body.from[v];
        if (body.start_from != nullptr) body.start_to[v] = body.start_from[v];
    }
}

/// Copies of positions that other devices have: a step reads them often. They come on a stream of
/// their own, beside what a device does with its own bodies.
class FarPositions {
public:
    FarPositions() {
        check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "a stream");
        for (cudaEvent_t* event : {&begun_, &done_})
            check(cudaEventCreateWithFlags(event, cudaEventDisableTiming), "an event");
    }
    FarPositions(const FarPositions&) = delete;
    ~FarPositions() {
        for (cudaEvent_t event : {begun_, done_}) cudaEventDestroy(event);
        cudaStreamDestroy(stream_);
    }

    void clear() {
        bodies_.clear();
        differs_ = true;
    }
    bool has(std::uint32_t body) const { return bodies_.contains(body); }
    void add(std::uint32_t body, const FarBody& far) {
        bodies_[body] = far;
        differs_ = true;
    }
    void remove(std::uint32_t body) { differs_ = bodies_.erase(body) > 0 || differs_; }

    /// Begins to copy when all is done that is issued on `ours`, which then waits for all bodies
    /// but ghosts.
    void fetch(cudaStream_t ours) {
        if (bodies_.empty()) return;
        check(cudaEventRecord(begun_, ours), "an event");
        check(cudaStreamWaitEvent(stream_, begun_), "an event");
        if (differs_) list();
        copy_far_positions<<<static_cast<unsigned>(listed_.size()), far_threads, 0, stream_>>>(
            view_of(std::as_const(listed_)));
        check(cudaGetLastError(), "a launch");
        check(cudaEventRecord(done_, stream_), "an event");
        if (!only_ghosts_) check(cudaStreamWaitEvent(ours, done_), "an event");
    }
    /// When all is copied.
    cudaEvent_t done() const { return done_; }

private:
    void list() {
        FarBody* const staged = staged_.resize(bodies_.size());
        std::size_t count = 0;
        only_ghosts_ = true;
        for (const auto& [body, far] : bodies_) {
            staged[count++] = far;
            only_ghosts_ = only_ghosts_ && far.is_ghost;
        }
        listed_.resize(static_cast<std::uint32_t>(count));
        copy(listed_.data(), staged, count, cudaMemcpyHostToDevice, stream_);
        differs_ = false;
    }

    std::map<std::uint32_t, FarBody> bodies_;  ///< by body
    bool differs_ = false;                     ///< from those listed
    bool only_ghosts_ = true;                  ///< all of those listed
    StagingBuffer<FarBody> staged_;
    DeviceBuffer<FarBody> listed_;
    cudaStream_t stream_ = nullptr;
    cudaEvent_t begun_ = nullptr, done_ = nullptr;
};

}  // namespace pierce::cuda
