#pragma once

#include <cuda_runtime.h>

#include <cub/block/block_reduce.cuh>
#include <cub/block/block_scan.cuh>

#include "core/device/warp.hpp"
#include "core/execute/executor.hpp"
#include "core/execute/stage_traits.hpp"
#include "gpu_cuda/device_count.hpp"
#include "gpu_cuda/launch_tuning.cuh"
#include "pierce/min_max.hpp"

/// What the executor launches: stages with a thread per item, lists continued past their end for
/// CUB, sums, and scans of and selections from short lists by one block. Lists that stages emit are
/// in emit_stage.cuh, short sorts are in counting_sort.cuh.
namespace pierce::cuda {

/// Threads of a block. Few items run in small blocks, which spread over more multiprocessors. Many
/// items run in large blocks: with small ones the GPU would wait for blocks to start, as starting a
/// block takes about 0.7 ns.
inline constexpr std::uint32_t few_threads = 64, block_threads = block_warps * warp_threads,
                               many_items = 1u << 18;

/// Up to this many items have several stages in one launch. Each thread then takes as many
/// registers as the largest of the stages needs, but all items still run at once.
inline constexpr std::uint32_t few_items = 1u << 15;

/// Up to this many groups of sixteen, a thread for each of the sixteen pays: they all run at once.
inline constexpr std::uint32_t few_sixteens = 1u << 13;

/// For lists up to this long, one block does scans and selections: more launches would cost more
/// than the work.
inline constexpr std::uint32_t short_list = 1u << 14;

/// The number of items, on the device; it is zero after a list of the step has outgrown its room,
/// so that nothing is written past the room.
struct Items {
    Number number;
    std::uint32_t bound = 0;
    const std::uint32_t* overflow = nullptr;

    Items(const DeviceCount& count, const std::uint32_t* outgrown)
        : number(count), bound(count.bound()), overflow(outgrown) {}
    __device__ std::uint32_t count() const { return *overflow == 0 ? std::uint32_t{number} : 0; }
};

/// Runs stages one after the other in the same thread.
template <class First, class... Rest>
struct InTurn {
    First first;
    InTurn<Rest...> rest;

    InTurn(const First& its_first, const Rest&... its_rest) : first(its_first), rest(its_rest...) {}
    __device__ void operator()(std::uint32_t i) const {
        first(i);
        rest(i);
    }
};
template <class Last>
struct InTurn<Last> {
    Last last;

    explicit InTurn(const Last& its_last) : last(its_last) {}
    __device__ void operator()(std::uint32_t i) const { last(i); }
};

template <class F>
__global__ void __launch_bounds__(block_threads, blocks_at_once<F>(block_threads))
    run_stage(const __grid_constant__ F stage, const Items items) {
    const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < items.count()) stage(i);
}

/// Makes the keys past the last one the largest, so that a sort puts them last.
struct PadKey {
    Items items;
    std::uint64_t* keys;

    __device__ void operator()(std::uint32_t i) const {
        if (i >= items.count()) keys[i] = ~std::uint64_t{0};
    }
};

/// Makes a 32-bit key of a key of no more than 32 bits. Keys past the last one become the largest,
/// so that a sort puts them last.
struct NarrowKey {
    Items items;
    const std::uint64_t* keys;
    std::uint32_t* narrow;

    __device__ void operator()(std::uint32_t i) const {
        narrow[i] = i < items.count() ? static_cast<std::uint32_t>(keys[i]) : ~std::uint32_t{0};
    }
};

/// Makes a 64-bit key of a 32-bit one.
struct WidenKey {
    Items items;
    const std::uint32_t* narrow;
    std::uint64_t* keys;

    __device__ void operator()(std::uint32_t i) const {
        keys[i] = i < items.count() ? std::uint64_t{narrow[i]} : ~std::uint64_t{0};
    }
};

/// A list of counts, continued with zeros.
struct CountAt {
    Items items;
    const std::uint32_t* in;

    __device__ std::uint32_t operator()(std::uint32_t i) const {
        return i < items.count() ? in[i] : 0;
    }
};

template <class F>
struct WantedAt {
    Items items;
    F wanted;

    __device__ bool operator()(std::uint32_t i) const { return i < items.count() && wanted(i); }
};

/// What a selection lists for an item that is wanted.
template <class F>
struct ListedAt {
    F wanted;

    __device__ std::uint32_t operator()(std::uint32_t i) const { return listed(wanted, i); }
};

template <class T>
struct FillWith {
    T* items;
    T value;

    __device__ void operator()(std::uint32_t i) const { items[i] = value; }
};

/// Says that a list has outgrown its room: to the step, and to the work beside the rest if the list
/// is part of it. Items::overflow is one of the two flags.
struct Overflow {
    std::uint32_t* flags;  ///< of the step, and of the work beside the rest
    bool is_beside;

    __device__ void set() const { flags[0] = flags[is_beside] = 1; }
};

/// Per item: there should be none.
struct SetOverflow {
    Overflow overflow;

    __device__ void operator()(std::uint32_t) const { overflow.set(); }
};

/// Writes a total: the sum of a scan, or the number of items that a selection has listed. The total
/// is limited to the room; `overflow` says whether it was larger.
struct NoteTotal {
    std::uint32_t room;
    std::uint32_t* total;
    Overflow overflow;

    __device__ void note(std::uint32_t sum) const {
        *total = min_of(sum, room);
        if (sum > room) overflow.set();
    }
    __device__ void operator()(std::ptrdiff_t, std::uint32_t sum) const { note(sum); }
};

/// Writes the offsets of a scan; with the last offset it also writes the total.
struct WriteOffset {
    CountAt counts;
    std::uint32_t* out;
    NoteTotal to;

    __device__ void operator()(std::ptrdiff_t at, std::uint32_t offset) const {
        const auto i = static_cast<std::uint32_t>(at);
        out[i] = offset;
        if (i + 1 == counts.items.bound) to.note(offset + counts(i));
    }
};

inline constexpr std::uint32_t most_sums = 512;  ///< blocks of a launch

struct Plus {
    template <class T>
    __device__ T operator()(const T& a, const T& b) const {
        return a + b;
    }
};

/// Adds up the terms of all items, in an order that depends on nothing but the launch. Every block
/// adds up the terms of its threads, and the last block to finish adds up the sums of all blocks.
/// `done`: the number of blocks that have finished; zero before and after.
template <std::uint32_t threads, class F, class T>
__global__ void __launch_bounds__(threads) add_up(const __grid_constant__ F term, const Items items,
                                                  T* sums, std::uint32_t* done, T* total) {
    using Reduce = cub::BlockReduce<T, threads>;
    __shared__ typename Reduce::TempStorage scratch;
    __shared__ bool is_last;
    const std::uint32_t count = items.count();
    T sum{};
    for (std::uint32_t i = blockIdx.x * threads + threadIdx.x; i < count; i += gridDim.x * threads)
        sum = sum + term(i);
    sum = Reduce(scratch).Reduce(sum, Plus{});
    if (threadIdx.x == 0) {
        sums[blockIdx.x] = sum;
        __threadfence();
        is_last = atomicAdd(done, 1) + 1 == gridDim.x;
    }
    __syncthreads();
    if (!is_last) return;
    __threadfence();
    sum = T{};
    for (std::uint32_t b = threadIdx.x; b < gridDim.x; b += threads) sum = sum + sums[b];
    sum = Reduce(scratch).Reduce(sum, Plus{});
    if (threadIdx.x != 0) return;
    *total = sum;
    *done = 0;
}

inline constexpr std::uint32_t scan_threads = 1024, scan_items = 8;

/// An exclusive scan by one block, which also writes the total.
inline __global__ void __launch_bounds__(scan_threads)
    scan_short_list(const CountAt in, std::uint32_t* out, const NoteTotal to) {
    using Scan = cub::BlockScan<std::uint32_t, scan_threads, cub::BLOCK_SCAN_WARP_SCANS>;
    __shared__ typename Scan::TempStorage scratch;
    const std::uint32_t count = in.items.count();
    std::uint32_t sum = 0;
    for (std::uint32_t begin = 0; begin < count; begin += scan_threads * scan_items) {
        const std::uint32_t first = begin + threadIdx.x * scan_items;
        std::uint32_t items[scan_items];  // loaded first, without reading the list's length each
                                          // time
        for (std::uint32_t k = 0; k < scan_items; ++k)
            items[k] = first + k < count ? in.in[first + k] : 0;
        std::uint32_t part = 0;
        Scan(scratch).ExclusiveSum(items, items, part);
        for (std::uint32_t k = 0; k < scan_items; ++k)
            if (first + k < count) out[first + k] = sum + items[k];
        sum += part;
        __syncthreads();
    }
    if (threadIdx.x == 0) to.note(sum);
}

/// Lists the wanted items by one block, and writes their number as the total.
template <class F>
__global__ void __launch_bounds__(scan_threads)
    select_from_short_list(const __grid_constant__ WantedAt<F> wanted, std::uint32_t* out,
                           const NoteTotal to) {
    using Scan = cub::BlockScan<std::uint32_t, scan_threads, cub::BLOCK_SCAN_WARP_SCANS>;
    __shared__ typename Scan::TempStorage scratch;
    const std::uint32_t count = wanted.items.count();
    std::uint32_t sum = 0;
    for (std::uint32_t begin = 0; begin < count; begin += scan_threads * scan_items) {
        const std::uint32_t first = begin + threadIdx.x * scan_items;
        std::uint32_t takes = 0;  // one bit per item
        for (std::uint32_t k = 0; k < scan_items; ++k)
            takes |= static_cast<std::uint32_t>(first + k < count && wanted.wanted(first + k)) << k;
        std::uint32_t place = 0, part = 0;
        Scan(scratch).ExclusiveSum(static_cast<std::uint32_t>(__popc(takes)), place, part);
        for (std::uint32_t k = 0; k < scan_items; ++k)
            if (takes >> k & 1) out[sum + place++] = listed(wanted.wanted, first + k);
        sum += part;
        __syncthreads();
    }
    if (threadIdx.x == 0) to.note(sum);
}

}  // namespace pierce::cuda
