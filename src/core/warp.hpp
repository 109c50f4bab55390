#pragma once

#include <cstdint>

#include "pierce/core/bits.hpp"
#include "pierce/core/config.hpp"
#include "pierce/core/whole.hpp"

/// What the threads of a warp do better together. On the host each item is alone.
namespace pierce {

/// Threads of a warp, and warps of the largest block on a GPU.
inline constexpr std::uint32_t warp_threads = 32, block_warps = 8;

/// Bits of a mask that is asked about.
inline constexpr std::uint32_t asked_bits = 16;

/// Asks test(item, bit) for every bit of `mask`, which has `asked_bits`; the answer has two bits. Returns the first ones in
/// the low half, the second ones in the high half. The test may depend on nothing but its arguments: on a GPU the bits of a
/// warp's items are shared out evenly, as a warp would otherwise wait for the item with the most.
template <class Test>
PIERCE_HD std::uint32_t ask_bits(std::uint32_t mask, std::uint32_t item, const Test& test) {
#if defined(__CUDA_ARCH__)
    if (__activemask() == 0xffffffffu) {
        struct Job {
            std::uint8_t lane, bit;
        };
        __shared__ Job jobs_of[block_warps][warp_threads * asked_bits];
        __shared__ std::uint32_t answers_of[block_warps][warp_threads], items_of[block_warps][warp_threads];
        const std::uint32_t lane = threadIdx.x % warp_threads, mine = threadIdx.x / warp_threads;
        const std::uint32_t count = bit_count(mask);
        std::uint32_t end = count;
        for (std::uint32_t step = 1; step < warp_threads; step *= 2) {
            const std::uint32_t before = __shfl_up_sync(0xffffffffu, end, step);
            if (lane >= step) end += before;
        }
        const std::uint32_t total = __shfl_sync(0xffffffffu, end, warp_threads - 1);
        std::uint32_t place = end - count;
        for (std::uint32_t left = mask; left != 0; left &= left - 1)
            jobs_of[mine][place++] = {static_cast<std::uint8_t>(lane), static_cast<std::uint8_t>(lowest_bit(left))};
        answers_of[mine][lane] = 0;
        items_of[mine][lane] = item;
        __syncwarp();
        for (std::uint32_t k = lane; k < total; k += warp_threads) {
            const Job job = jobs_of[mine][k];
            const std::uint32_t answer = test(items_of[mine][job.lane], std::uint32_t{job.bit});
            const std::uint32_t bits = (answer & 1) << job.bit | (answer >> 1) << (job.bit + asked_bits);
            if (bits != 0) atomicOr(&answers_of[mine][job.lane], bits);
        }
        __syncwarp();
        const std::uint32_t answers = answers_of[mine][lane];
        __syncwarp();
        return answers;
    }
#endif
    std::uint32_t answers = 0;
    for (std::uint32_t left = mask; left != 0; left &= left - 1) {
        const std::uint32_t bit = lowest_bit(left), answer = test(item, bit);
        answers |= (answer & 1) << bit | (answer >> 1) << (bit + asked_bits);
    }
    return answers;
}

/// Writes items[i], where threads side by side write items side by side. On a GPU a warp brings its items into order first
/// and writes them word after word: an item at a time, every word is a memory access that reaches a small part of a line.
template <class T>
PIERCE_HD void write_side_by_side(T* items, std::uint32_t i, const T& value) {
#if defined(__CUDA_ARCH__)
    constexpr std::uint32_t words = sizeof(T) / 16, half = warp_threads / 2;
    __shared__ uint4 ordered[block_warps][half * words];
    if (__activemask() != 0xffffffffu) return write_whole(items[i], value);
    const std::uint32_t lane = threadIdx.x % warp_threads;
    uint4* const mine = ordered[threadIdx.x / warp_threads];
    detail::Words<T> parts;
    memcpy(&parts, &value, sizeof(T));
    for (std::uint32_t begin = 0; begin < warp_threads; begin += half) {
        if (lane >= begin && lane < begin + half)
            for (std::uint32_t k = 0; k < words; ++k)
                mine[(lane - begin) * words + k] = *reinterpret_cast<const uint4*>(&parts.word[k]);
        __syncwarp();
        uint4* const to = reinterpret_cast<uint4*>(items + (i - lane + begin));
        for (std::uint32_t w = lane; w < half * words; w += warp_threads) to[w] = mine[w];
        __syncwarp();
    }
#else
    items[i] = value;
#endif
}

}  // namespace pierce
