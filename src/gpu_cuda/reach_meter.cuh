#pragma once

#include <bit>
#include <cmath>
#include <vector>

#include "core/base/usable.hpp"
#include "core/body/body_view.hpp"
#include "core/body/reach.hpp"
#include "core/device/view.hpp"
#include "gpu_cuda/device_buffer.hpp"
#include "gpu_cuda/device_copy.hpp"
#include "pierce/pose.hpp"

namespace pierce::cuda {

/// What is read to measure the reach of a body whose place is in device memory.
struct ReachSource {
    const Vec3f* positions = nullptr;  ///< of a deforming body
    const Vec3f* start = nullptr;
    std::uint32_t count = 0;
    DevicePose pose;  ///< of any other body
    Box local;        ///< around its vertices, in its own space
    double more = 0;
};

inline constexpr unsigned reach_threads = 128;

/// A block per body. `told`: what fetch() has told; empty if nothing. `grown`: the most that reach
/// has grown since, as the bits of a double.
inline __global__ void measure_reach(View<const ReachSource> sources, View<Box> reach,
                                     View<const Box> told, unsigned long long* grown) {
    const ReachSource source = sources[blockIdx.x];
    PlacedBox mine;
    if (source.positions != nullptr) {
        double squared = 0;
        for (std::uint32_t v = threadIdx.x; v < source.count; v += blockDim.x) {
            const Vec3d p = to_double(source.positions[v]);
            mine.box.extend(p);
            if (source.start != nullptr)
                squared = max_of(length_squared(p - to_double(source.start[v])), squared);
        }
        mine.travel = sqrt(squared);
    } else if (threadIdx.x == 0) {
        const Pose pose = source.pose.read();
        if (is_usable(pose)) mine = placed_box(source.local, frame_of(pose));
    }
    // The largest of what the threads have: -lower, upper, travel.
    constexpr int values = 7;
    __shared__ double most[values][reach_threads];
    for (int k = 0; k < 3; ++k) {
        most[k][threadIdx.x] = -mine.box.lower[k];
        most[3 + k][threadIdx.x] = mine.box.upper[k];
    }
    most[6][threadIdx.x] = mine.travel;
    for (unsigned step = reach_threads / 2; step > 0; step /= 2) {
        __syncthreads();
        if (threadIdx.x >= step) continue;
        for (int k = 0; k < values; ++k)
            most[k][threadIdx.x] = max_of(most[k][threadIdx.x + step], most[k][threadIdx.x]);
    }
    if (threadIdx.x > 0) return;
    const PlacedBox all = {
        {{-most[0][0], -most[1][0], -most[2][0]}, {most[3][0], most[4][0], most[5][0]}},
        most[6][0]};
    const Box reaches = reach_of(all, source.more);
    reach[blockIdx.x] = reaches;
    if (told.size == 0) return;
    // Doubles that are not negative are ordered as their bits are.
    const double growth = growth_of(told[blockIdx.x], reaches);
    if (growth > 0) atomicMax(grown, static_cast<unsigned long long>(__double_as_longlong(growth)));
}

/// Measures the reach of bodies that have their places in device memory.
class ReachMeter {
public:
    /// As Backend::measure_reach(). Waits for the device, unless there is nothing to compare with;
    /// fetch() follows then.
    double measure(View<const BodyView> bodies, View<const std::uint32_t> some,
                   View<const double> more, bool anew, cudaStream_t stream) {
        if (some.size == 0) return 0;
        if (anew) {
            told_.clear();
            ReachSource* const sources = staged_.resize(some.size);
            for (std::uint32_t k = 0; k < some.size; ++k) {
                const BodyView& body = bodies[some[k]];
                sources[k] = {.positions = body.device_positions,
                              .start = body.device_start,
                              .count = body.mesh.positions.size,
                              .pose = body.device_pose,
                              .local = body.mesh.box,
                              .more = more[k]};
            }
            sources_.resize(some.size);
            reach_.resize(some.size);
            copy(sources_.data(), sources, some.size, cudaMemcpyHostToDevice, stream);
        }
        grown_.resize(1);
        check(cudaMemsetAsync(grown_.data(), 0, sizeof(unsigned long long), stream), "a zero");
        measure_reach<<<some.size, reach_threads, 0, stream>>>(
            view_of(std::as_const(sources_)), view_of(reach_), view_of(std::as_const(told_)),
            grown_.data());
        check(cudaGetLastError(), "a launch");
        if (told_.empty()) return INFINITY;
        unsigned long long* const grown = grown_on_host_.resize(1);
        copy(grown, grown_.data(), 1, cudaMemcpyDeviceToHost, stream);
        check(cudaStreamSynchronize(stream), "waiting for the device");
        return std::bit_cast<double>(*grown);
    }

    /// As Backend::fetch_reach(). Waits for the device.
    void fetch(View<const std::uint32_t> some, View<Box> reach, cudaStream_t stream) {
        if (some.size == 0) return;
        told_.resize(some.size);
        copy(told_.data(), reach_.data(), some.size, cudaMemcpyDeviceToDevice, stream);
        Box* const found = found_.resize(some.size);
        copy(found, reach_.data(), some.size, cudaMemcpyDeviceToHost, stream);
        check(cudaStreamSynchronize(stream), "waiting for the device");
        for (std::uint32_t k = 0; k < some.size; ++k) reach[some[k]] = found[k];
    }

private:
    StagingBuffer<ReachSource> staged_;
    StagingBuffer<Box> found_;
    StagingBuffer<unsigned long long> grown_on_host_;
    DeviceBuffer<ReachSource> sources_;
    DeviceBuffer<Box> reach_, told_;
    DeviceBuffer<unsigned long long> grown_;
};

}  // namespace pierce::cuda
