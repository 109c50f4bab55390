#pragma once

#include "gpu_cuda/stage_kernels.cuh"
#include "pierce/min_max.hpp"

/// Lists of what stages find, found and written in one launch.
namespace pierce::cuda {

/// From this many items on, a stage that emits a list runs in large blocks: small blocks would wait
/// for each other.
inline constexpr std::uint32_t many_emitting = 1u << 15;

/// The sums of the blocks of a launch, one word per block. A word first holds the block's own sum,
/// then the sum of all blocks up to it. A word is read and written whole. `epoch` differs from
/// launch to launch, so that words of earlier launches need not be cleared.
struct BlockSums {
    std::uint64_t* words;
    const std::uint32_t* epoch;

    /// The sum of all blocks before this one, whose own sum is `sum`; a whole warp calls it. The
    /// warp looks back at earlier blocks, as many at a time as it has threads, until one knows the
    /// sum of all blocks up to it (Merrill and Garland 2016, decoupled look-back). Blocks start in
    /// their order, so the blocks that it waits for are already running.
    __device__ std::uint32_t before(std::uint32_t sum) const {
        const std::uint32_t block = blockIdx.x, lane = threadIdx.x % warp_threads, now = *epoch;
        if (lane == 0) write(block, now, block == 0, sum);
        std::uint32_t before = 0;
        for (std::uint32_t end = block; end > 0; end -= min_of(end, warp_threads)) {
            std::uint64_t word = 0;
            if (lane < end) {
                do word = static_cast<volatile std::uint64_t*>(words)[end - 1 - lane];
                while (static_cast<std::uint32_t>(word >> 33) != now);
            }
            const std::uint32_t of_all = __ballot_sync(0xffffffffu, word >> 32 & 1);
            const std::uint32_t nearest = of_all == 0 ? warp_threads - 1 : lowest_bit(of_all);
            std::uint32_t part = lane <= nearest ? static_cast<std::uint32_t>(word) : 0;
            for (std::uint32_t step = warp_threads / 2; step > 0; step /= 2)
                part += __shfl_xor_sync(0xffffffffu, part, step);
            before += part;
            if (of_all != 0) break;
        }
        if (lane == 0 && block > 0) write(block, now, true, before + sum);
        return before;
    }

private:
    __device__ void write(std::uint32_t block, std::uint32_t now, bool is_of_all,
                          std::uint32_t sum) const {
        static_cast<volatile std::uint64_t*>(words)[block] = std::uint64_t{now} << 33 |
                                                             std::uint64_t{is_of_all} << 32 | sum;
    }
};

/// Sets each total to zero. It begins a launch that emits a list, or several launches with words
/// and totals of their own. An epoch is never zero, as new words are zero.
struct BeginLists {
    std::uint32_t* totals;
    std::uint32_t* epoch;

    __device__ void operator()(std::uint32_t i) const {
        totals[i] = 0;
        if (i == 0) *epoch = max_of((*epoch + 1) & 0x7fffffffu, 1u);
    }
};

/// The room for what items find, and the place for the total, which is written even if there is not
/// enough room.
struct Emitted {
    std::uint32_t room;
    std::uint32_t* total;  ///< zero at first
    Overflow overflow;
    BlockSums sums;
    bool in_order;
};

/// Up to this many blocks, lists are in the order of items even if the stage does not ask for it,
/// as a nearly sorted list of contacts is sorted faster. A block waits for the blocks before it;
/// with many blocks, that takes longer than the work.
inline constexpr std::uint32_t few_blocks = 512;

/// True for a stage that fills its lists past the last thing.
template <class F, class... T>
constexpr bool pads() {
    return requires(const F& finder, T*... lists) { finder.pad(0u, lists...); };
}

/// Writes what items find. A block without enough room writes nothing. Without lists, things are
/// only counted.
template <class F, class... T>
__global__ void __launch_bounds__(block_threads, blocks_at_once<F>(block_threads))
    emit_stage(const __grid_constant__ F finder, const Items items, const Emitted to,
               T* const... lists) {
    __shared__ std::uint32_t of_warps[block_warps], begin;
    const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
    const std::uint32_t lane = threadIdx.x % warp_threads, warp = threadIdx.x / warp_threads;
    const bool is_item = i < items.count();
    decltype(finder.find(0)) found{};
    if (is_item) found = finder.find(i);
    const std::uint32_t count = is_item ? finder.count(found) : 0;
    std::uint32_t end = count;
    for (std::uint32_t step = 1; step < warp_threads; step *= 2) {
        const std::uint32_t before = __shfl_up_sync(0xffffffffu, end, step);
        if (lane >= step) end += before;
    }
    if (lane == warp_threads - 1) of_warps[warp] = end;
    __syncthreads();
    std::uint32_t place = end - count, sum = 0;
    for (std::uint32_t w = 0; w < blockDim.x / warp_threads; ++w) {
        if (w == warp) place += sum;
        sum += of_warps[w];
    }
    if (warp == 0) {
        std::uint32_t before = 0;
        if (to.in_order)
            before = to.sums.before(sum);
        else if (lane == 0 && sum > 0)
            before = atomicAdd(to.total, sum);
        if (lane == 0) {
            begin = before;
            if (to.in_order && blockIdx.x + 1 == gridDim.x) *to.total = before + sum;
            if (sum > 0 && std::uint64_t{before} + sum > to.room) to.overflow.set();
        }
    }
    __syncthreads();
    if constexpr (sizeof...(T) > 0)
        if (is_item && sum > 0 && std::uint64_t{begin} + sum <= to.room)
            finder.write(i, found, begin + place, lists...);
    // pads() is a function, as nvcc 13.0 evaluates a `requires` with a pack only once, for the
    // launch without lists.
    if constexpr (pads<F, T...>()) {
        static_assert(in_order<F>(), "the last block knows where the list ends");
        if (blockIdx.x + 1 == gridDim.x)
            for (std::uint32_t k = begin + sum + threadIdx.x; k < to.room; k += blockDim.x)
                finder.pad(k, lists...);
    }
}

}  // namespace pierce::cuda
