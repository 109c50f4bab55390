// What a byte costs between devices, and between a device and the host: pierce_gpu_links
// Copies as steps make them: positions of ghosts from another device's memory by a kernel, places
// to pinned memory and from there. Prints CSV: the median of many copies, waited for one by one.
#include <cuda_runtime.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <utility>
#include <vector>

#include "core/device/view.hpp"
#include "gpu_cuda/cuda_check.hpp"
#include "gpu_cuda/device_buffer.hpp"
#include "gpu_cuda/far_positions.cuh"
#include "gpu_cuda/on_device.hpp"

namespace pierce {
namespace {

using cuda::check;

constexpr int copies = 200;
constexpr std::uint32_t vertices_of_a_body = 300;

/// [µs] Median of what it takes until all that `copy` issues is done.
double microseconds(const std::function<void()>& copy) {
    std::vector<double> took;
    for (int i = 0; i < copies; ++i) {
        const auto begin = std::chrono::steady_clock::now();
        copy();
        check(cudaDeviceSynchronize(), "waiting for the device");
        took.push_back(
            std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin)
                .count());
    }
    std::ranges::nth_element(took, took.begin() + copies / 2);
    return took[copies / 2];
}

void print(const char* link, std::size_t bytes, double us) {
    std::printf("%s,%zu,%.2f,%.2f\n", link, bytes, us, static_cast<double>(bytes) / us / 1e3);
}

/// Positions of ghosts from the memory of device `from` to that of the current one.
void ghosts(const char* link, int from, std::uint32_t bodies) {
    const std::size_t vertices = std::size_t{bodies} * vertices_of_a_body;
    Vec3f *there = nullptr, *here = nullptr;
    {
        const cuda::OnDevice other(from);
        check(cudaMalloc(&there, vertices * sizeof(Vec3f)), "memory");
    }
    check(cudaMalloc(&here, vertices * sizeof(Vec3f)), "memory");
    std::vector<cuda::FarBody> list(bodies);
    for (std::uint32_t b = 0; b < bodies; ++b)
        list[b] = {.from = there + std::size_t{b} * vertices_of_a_body,
                   .start_from = nullptr,
                   .to = here + std::size_t{b} * vertices_of_a_body,
                   .start_to = nullptr,
                   .count = vertices_of_a_body};
    cuda::DeviceBuffer<cuda::FarBody> far;
    far.resize(bodies);
    check(
        cudaMemcpy(far.data(), list.data(), bodies * sizeof(cuda::FarBody), cudaMemcpyHostToDevice),
        "a list");
    print(link, vertices * sizeof(Vec3f), microseconds([&] {
              cuda::copy_far_positions<<<bodies, cuda::far_threads>>>(view_of(std::as_const(far)));
          }));
    cudaFree(here);
    cudaFree(there);
}

void to_and_from_host(std::size_t bytes) {
    cuda::DeviceBuffer<char> device;
    device.resize(bytes);
    cuda::StagingBuffer<char> pinned;
    char* const host = pinned.resize(bytes);
    std::vector<char> pageable(bytes);
    const auto measure = [&](const char* link, void* to, const void* from) {
        print(link, bytes, microseconds([&] {
                  check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDefault), "a copy");
              }));
    };
    measure("to pinned memory", host, device.data());
    measure("from pinned memory", device.data(), host);
    measure("to other memory", pageable.data(), device.data());
    measure("from other memory", device.data(), pageable.data());
}

void run() {
    int devices = 0;
    check(cudaGetDeviceCount(&devices), "the number of devices");
    std::puts("link,bytes,us,gb_per_s");
    if (devices > 1) check(cudaDeviceEnablePeerAccess(1, 0), "access to the other device");
    for (const std::uint32_t bodies : {1u, 30u, 300u, 3000u, 30000u}) {
        ghosts("in one device", 0, bodies);
        if (devices > 1) ghosts("from another device", 1, bodies);
    }
    for (const std::size_t bytes : {std::size_t{4096}, std::size_t{100'000}, std::size_t{1'000'000},
                                    std::size_t{10'000'000}, std::size_t{100'000'000}})
        to_and_from_host(bytes);
}

}  // namespace
}  // namespace pierce

int main() { pierce::run(); }
