#pragma once

#include <cuda_runtime.h>

#include <cub/block/block_scan.cuh>

#include "pierce/core/float_rules.hpp"
#include "pierce/gpu_cuda/device_count.hpp"

/// What the executor launches: a thread an item, lists continued past their end for CUB, and short lists scanned, selected
/// from and sorted by one block.
namespace pierce::cuda {

inline constexpr std::uint32_t block_threads = 64;

/// Lists up to this long are scanned and selected from by one block, and merge sorted: launches cost more than the work.
inline constexpr std::uint32_t short_list = 1u << 16;

/// The number of items, on the device; none once a list of the step has outgrown its room, so that nobody writes past it.
struct Items {
    std::uint32_t bound = 0;
    const std::uint32_t* exact = nullptr;
    std::uint32_t factor = 1;
    const std::uint32_t* overflow = nullptr;

    Items(const DeviceCount& count, const std::uint32_t* outgrown)
        : bound(count.bound), exact(count.exact), factor(count.factor), overflow(outgrown) {}
    __device__ std::uint32_t count() const {
        const std::uint32_t known = exact == nullptr ? bound : min_of(*exact * factor, bound);
        return *overflow == 0 ? known : 0;
    }
};

/// How many blocks of a stage must fit on a multiprocessor: more hide more waiting, with less room for each. A stage may
/// say so (`static constexpr int blocks_at_once`).
template <class F>
constexpr int blocks_at_once() {
    if constexpr (requires { F::blocks_at_once; })
        return F::blocks_at_once;
    else
        return 1;
}

template <class F>
__global__ void __launch_bounds__(block_threads, blocks_at_once<F>())
    run_stage(const __grid_constant__ F stage, const Items items) {
    const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < items.count()) stage(i);
}

/// Keys past the last one go last in a sort.
struct PadKey {
    Items items;
    std::uint64_t* keys;

    __device__ void operator()(std::uint32_t i) const {
        if (i >= items.count()) keys[i] = ~std::uint64_t{0};
    }
};

/// A list of counts, continued with zeros.
struct CountAt {
    Items items;
    const std::uint32_t* in;

    __device__ std::uint32_t operator()(std::uint32_t i) const { return i < items.count() ? in[i] : 0; }
};

/// Terms of a sum, continued with nothing.
template <class F, class T>
struct TermAt {
    Items items;
    F term;

    __device__ T operator()(std::uint32_t i) const { return i < items.count() ? term(i) : T{}; }
};

template <class F>
struct WantedAt {
    Items items;
    F wanted;

    __device__ bool operator()(std::uint32_t i) const { return i < items.count() && wanted(i); }
};

struct Less {
    __device__ bool operator()(std::uint64_t a, std::uint64_t b) const { return a < b; }
};

struct Plus {
    template <class T>
    __host__ __device__ T operator()(const T& a, const T& b) const {
        return a + b;
    }
};

template <class T>
struct FillWith {
    T* items;
    T value;

    __device__ void operator()(std::uint32_t i) const { items[i] = value; }
};

/// A total: of a scan, or what a selection has written. No more than there is room for is kept; `overflow` says
/// if there was not.
struct NoteTotal {
    const std::uint32_t* offsets;  ///< null: the total is there already
    CountAt last;
    std::uint32_t room;
    std::uint32_t* total;
    std::uint32_t* overflow;

    __device__ void operator()(std::uint32_t) const {
        const std::uint32_t bound = last.items.bound;
        note(offsets != nullptr ? offsets[bound - 1] + last(bound - 1) : *total);
    }
    __device__ void note(std::uint32_t sum) const {
        *total = min_of(sum, room);
        if (sum > room) *overflow = 1;
    }
};

inline constexpr std::uint32_t scan_threads = 1024, scan_items = 8;

/// An exclusive scan by one block, which notes the total, too.
inline __global__ void __launch_bounds__(scan_threads)
    scan_short_list(const CountAt in, std::uint32_t* out, const NoteTotal to) {
    using Scan = cub::BlockScan<std::uint32_t, scan_threads>;
    __shared__ typename Scan::TempStorage scratch;
    const std::uint32_t count = in.items.count();
    std::uint32_t sum = 0;
    for (std::uint32_t begin = 0; begin < count; begin += scan_threads * scan_items) {
        const std::uint32_t first = begin + threadIdx.x * scan_items;
        std::uint32_t items[scan_items];
        for (std::uint32_t k = 0; k < scan_items; ++k) items[k] = in(first + k);
        std::uint32_t part = 0;
        Scan(scratch).ExclusiveSum(items, items, part);
        for (std::uint32_t k = 0; k < scan_items; ++k)
            if (first + k < count) out[first + k] = sum + items[k];
        sum += part;
        __syncthreads();
    }
    if (threadIdx.x == 0) to.note(sum);
}

/// Lists the wanted items by one block, and notes how many they are.
template <class F>
__global__ void __launch_bounds__(scan_threads)
    select_from_short_list(const __grid_constant__ WantedAt<F> wanted, std::uint32_t* out, const NoteTotal to) {
    using Scan = cub::BlockScan<std::uint32_t, scan_threads>;
    __shared__ typename Scan::TempStorage scratch;
    const std::uint32_t count = wanted.items.count();
    std::uint32_t sum = 0;
    for (std::uint32_t begin = 0; begin < count; begin += scan_threads * scan_items) {
        const std::uint32_t first = begin + threadIdx.x * scan_items;
        std::uint32_t takes = 0;  // a bit an item
        for (std::uint32_t k = 0; k < scan_items; ++k) takes |= static_cast<std::uint32_t>(wanted(first + k)) << k;
        std::uint32_t place = 0, part = 0;
        Scan(scratch).ExclusiveSum(static_cast<std::uint32_t>(__popc(takes)), place, part);
        for (std::uint32_t k = 0; k < scan_items; ++k)
            if (takes >> k & 1) out[sum + place++] = first + k;
        sum += part;
        __syncthreads();
    }
    if (threadIdx.x == 0) to.note(sum);
}

inline constexpr std::uint32_t sort_threads = 1024;

/// Lists up to this long are sorted by one block.
inline constexpr std::uint32_t very_short_list = 2 * sort_threads;

/// Sorts keys and moves their values along, by exchanges in a fixed order (Batcher's bitonic network) of keys and where they
/// have come from; stable. What is past the last key becomes the largest.
inline __global__ void __launch_bounds__(sort_threads)
    sort_very_short_list(const Items items, std::uint64_t* keys, std::uint32_t* values) {
    __shared__ std::uint64_t key[very_short_list];
    __shared__ std::uint16_t from[very_short_list];
    const std::uint32_t count = items.count();
    std::uint32_t size = 1;
    while (size < count) size *= 2;
    for (std::uint32_t i = threadIdx.x; i < size; i += blockDim.x) {
        key[i] = i < count ? keys[i] : ~std::uint64_t{0};
        from[i] = static_cast<std::uint16_t>(i);
    }
    for (std::uint32_t run = 2; run <= size; run *= 2)
        for (std::uint32_t apart = run / 2; apart > 0; apart /= 2) {
            __syncthreads();
            for (std::uint32_t t = threadIdx.x; t < size / 2; t += blockDim.x) {
                const std::uint32_t i = 2 * t - (t & (apart - 1)), k = i + apart;
                const std::uint64_t first = key[i], second = key[k];
                const std::uint16_t of_first = from[i], of_second = from[k];
                const bool in_order = first < second || (first == second && of_first < of_second);
                if (in_order == ((i & run) == 0)) continue;
                key[i] = second;
                key[k] = first;
                from[i] = of_second;
                from[k] = of_first;
            }
        }
    __syncthreads();
    std::uint32_t value[2];
    for (std::uint32_t n = 0; n < 2; ++n)
        if (const std::uint32_t i = n * blockDim.x + threadIdx.x; i < count) value[n] = values[from[i]];
    __syncthreads();
    for (std::uint32_t n = 0; n < 2; ++n) {
        const std::uint32_t i = n * blockDim.x + threadIdx.x;
        if (i < count) values[i] = value[n];
        if (i < items.bound) keys[i] = i < count ? key[i] : ~std::uint64_t{0};
    }
}

}  // namespace pierce::cuda
