#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/body/fetched_place.hpp"
#include "core/device/view.hpp"
#include "gpu_cuda/device_buffer.hpp"
#include "gpu_cuda/device_copy.hpp"
#include "gpu_cuda/far_positions.cuh"

namespace pierce::cuda {

/// Per body: reads its pose, if it is in device memory.
inline __global__ void read_poses(View<const DevicePose> from, View<Pose> poses) {
    const std::uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k < from.size && from[k].exists()) poses[k] = from[k].read();
}

/// Brings places that are in device memory to the host: together on the device, then by one copy to
/// pinned memory.
class PlaceFetcher {
public:
    /// As Backend::fetch_places(). Waits for the device.
    View<const FetchedPlace> fetch(View<const BodyView> bodies, View<const std::uint32_t> some,
                                   cudaStream_t stream) {
        fetched_.assign(some.size, {});
        if (some.size == 0) return {};
        const auto count_of = [](const BodyView& body) {
            return body.device_positions == nullptr ? 0 : body.positions.size;
        };
        std::size_t vertices = 0;
        for (const std::uint32_t b : some) vertices += 2 * std::size_t{count_of(bodies[b])};
        together_.resize(vertices);
        Vec3f* const positions = on_host_.resize(vertices);
        FarBody* const far = staged_far_.resize(some.size);
        DevicePose* const from = staged_from_.resize(some.size);
        std::size_t at = 0;
        for (std::uint32_t k = 0; k < some.size; ++k) {
            const BodyView& body = bodies[some[k]];
            const std::uint32_t count = count_of(body);
            from[k] = body.device_pose;
            far[k] = {.is_ghost = false,
                      .from = body.device_positions,
                      .start_from = body.device_start,
                      .to = together_.data() + at,
                      .start_to = together_.data() + at + count,
                      .count = count};
            fetched_[k].positions = {positions + at, count};
            if (body.device_start != nullptr) fetched_[k].start = {positions + at + count, count};
            at += 2 * std::size_t{count};
        }
        far_.resize(some.size);
        from_.resize(some.size);
        poses_.resize(some.size);
        copy(far_.data(), far, some.size, cudaMemcpyHostToDevice, stream);
        copy(from_.data(), from, some.size, cudaMemcpyHostToDevice, stream);
        copy_far_positions<<<some.size, far_threads, 0, stream>>>(view_of(std::as_const(far_)));
        check(cudaGetLastError(), "a launch");
        read_poses<<<(some.size + far_threads - 1) / far_threads, far_threads, 0, stream>>>(
            view_of(std::as_const(from_)), view_of(poses_));
        check(cudaGetLastError(), "a launch");
        Pose* const poses = poses_on_host_.resize(some.size);
        copy(poses, poses_.data(), some.size, cudaMemcpyDeviceToHost, stream);
        copy(positions, together_.data(), at, cudaMemcpyDeviceToHost, stream);
        check(cudaStreamSynchronize(stream), "waiting for the device");
        for (std::uint32_t k = 0; k < some.size; ++k) fetched_[k].pose = poses[k];
        return view_of(std::as_const(fetched_));
    }

private:
    StagingBuffer<FarBody> staged_far_;
    StagingBuffer<DevicePose> staged_from_;
    StagingBuffer<Pose> poses_on_host_;
    StagingBuffer<Vec3f> on_host_;
    DeviceBuffer<FarBody> far_;
    DeviceBuffer<DevicePose> from_;
    DeviceBuffer<Pose> poses_;
    DeviceBuffer<Vec3f> together_;  ///< per body, positions and where the step began
    std::vector<FetchedPlace> fetched_;
};

}  // namespace pierce::cuda
