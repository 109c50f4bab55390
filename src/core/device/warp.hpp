#pragma once

#include <cstdint>
#include <cstring>

#include "core/device/bits.hpp"
#include "core/device/whole.hpp"
#include "pierce/host_device.hpp"

/// Work that the threads of a warp share. On the host each item works alone.
namespace pierce {

/// Threads of a warp, and warps of the largest block on a GPU.
inline constexpr std::uint32_t warp_threads = 32, block_warps = 8;

/// The most bits of a mask that ask_bits() can test.
inline constexpr std::uint32_t asked_bits = 16;

#if defined(__CUDA_ARCH__)
namespace detail {
/// The set bits of a warp's masks, one after the other, so that its threads have equally many to
/// process.
template <std::uint32_t bits>
struct WarpBits {
    struct Job {
        std::uint8_t lane, bit;
    };
    Job jobs[warp_threads * bits];
    std::uint32_t items[warp_threads];

    /// Lists the bits of the masks of a warp and returns their number; all threads of the warp must
    /// call it.
    __device__ std::uint32_t list(std::uint32_t mask, std::uint32_t item) {
        const std::uint32_t lane = threadIdx.x % warp_threads, count = bit_count(mask);
        std::uint32_t end = count;
        for (std::uint32_t step = 1; step < warp_threads; step *= 2) {
            const std::uint32_t before = __shfl_up_sync(0xffffffffu, end, step);
            if (lane >= step) end += before;
        }
        std::uint32_t place = end - count;
        for (std::uint32_t left = mask; left != 0; left &= left - 1)
            jobs[place++] = {static_cast<std::uint8_t>(lane),
                             static_cast<std::uint8_t>(lowest_bit(left))};
        items[lane] = item;
        __syncwarp();
        return __shfl_sync(0xffffffffu, end, warp_threads - 1);
    }
};
}  // namespace detail
#endif

/// Calls test(item, bit) for every set bit of `mask`; only the lowest `bits` may be set. Each
/// answer has two bits. Returns the answers' first bits in the low half and their second bits in
/// the high half. The test may depend on nothing but its arguments. On a GPU the bits of a warp's
/// items are shared out evenly, as a warp would otherwise wait for the item with the most bits.
template <std::uint32_t bits = asked_bits, class Test>
PIERCE_HD std::uint32_t ask_bits(std::uint32_t mask, std::uint32_t item, const Test& test) {
    static_assert(bits <= asked_bits);
#if defined(__CUDA_ARCH__)
    if (__activemask() == 0xffffffffu) {
        __shared__ detail::WarpBits<bits> bits_of[block_warps];
        __shared__ std::uint32_t answers_of[block_warps][warp_threads];
        const std::uint32_t lane = threadIdx.x % warp_threads;
        detail::WarpBits<bits>& asked = bits_of[threadIdx.x / warp_threads];
        std::uint32_t* const answers = answers_of[threadIdx.x / warp_threads];
        answers[lane] = 0;
        const std::uint32_t total = asked.list(mask, item);
        for (std::uint32_t k = lane; k < total; k += warp_threads) {
            const auto job = asked.jobs[k];
            const std::uint32_t answer = test(asked.items[job.lane], std::uint32_t{job.bit});
            const std::uint32_t both = (answer & 1) << job.bit | (answer >> 1)
                                                                     << (job.bit + asked_bits);
            if (both != 0) atomicOr(&answers[job.lane], both);
        }
        __syncwarp();
        const std::uint32_t mine = answers[lane];
        __syncwarp();
        return mine;
    }
#endif
    std::uint32_t answers = 0;
    for (std::uint32_t left = mask; left != 0; left &= left - 1) {
        const std::uint32_t bit = lowest_bit(left), answer = test(item, bit);
        answers |= (answer & 1) << bit | (answer >> 1) << (bit + asked_bits);
    }
    return answers;
}

/// Calls write(item, mask, bit, place) for every set bit among the lowest `bits` of `mask`. The
/// lowest bit gets `place`, and the others get the places after it. The places of the next item
/// must follow. On a GPU a warp shares out its items' bits, so that threads side by side write to
/// places side by side.
template <std::uint32_t bits, class Write>
PIERCE_HD void write_bits(std::uint32_t mask, std::uint32_t item, std::uint32_t place,
                          const Write& write) {
    const std::uint32_t written = mask & (~std::uint32_t{0} >> (32 - bits));
#if defined(__CUDA_ARCH__)
    if (__activemask() == 0xffffffffu) {
        __shared__ detail::WarpBits<bits> bits_of[block_warps];
        __shared__ std::uint32_t masks_of[block_warps][warp_threads];
        const std::uint32_t lane = threadIdx.x % warp_threads, warp = threadIdx.x / warp_threads;
        detail::WarpBits<bits>& listed = bits_of[warp];
        masks_of[warp][lane] = mask;
        const std::uint32_t total = listed.list(written, item),
                            first = __shfl_sync(0xffffffffu, place, 0);
        for (std::uint32_t k = lane; k < total; k += warp_threads) {
            const auto job = listed.jobs[k];
            write(listed.items[job.lane], masks_of[warp][job.lane], std::uint32_t{job.bit},
                  first + k);
        }
        return;
    }
#endif
    for (std::uint32_t left = written; left != 0; left &= left - 1)
        write(item, mask, lowest_bit(left), place++);
}

/// How the sixteen things of a group are shared out: here an item of a stage handles all of them.
struct AllOfSixteen {
    static constexpr std::uint32_t count = 16;  ///< things that an item handles
    PIERCE_HD static std::uint32_t first() { return 0; }
    PIERCE_HD static std::uint32_t group_of(std::uint32_t item) { return item; }

    /// The bits of a mask that belong to this item.
    PIERCE_HD static std::uint32_t mine(std::uint32_t mask) { return mask; }
    /// Joins the bits that the items of a group found for their own things; all items of the group
    /// must call it.
    PIERCE_HD static std::uint32_t of_all(std::uint32_t bits) { return bits; }
    /// The least of the items' numbers; all items of the group must call it.
    PIERCE_HD static float least_of_all(float least) { return least; }
};

#if defined(__CUDACC__)
/// The same with an item that handles one of the sixteen things, so that few groups take less time
/// on a GPU.
struct OneOfSixteen {
    static constexpr std::uint32_t count = 1;
    static __device__ std::uint32_t first() { return threadIdx.x % AllOfSixteen::count; }
    static __device__ std::uint32_t group_of(std::uint32_t item) {
        return item / AllOfSixteen::count;
    }
    static __device__ std::uint32_t mine(std::uint32_t mask) { return mask & 1u << first(); }
    static __device__ std::uint32_t of_all(std::uint32_t bits) {
        return (__ballot_sync(group(), bits != 0) >> (threadIdx.x & AllOfSixteen::count)) & 0xffffu;
    }
    static __device__ float least_of_all(float least) {
        for (std::uint32_t step = AllOfSixteen::count / 2; step > 0; step /= 2)
            least = fminf(least, __shfl_xor_sync(group(), least, step));
        return least;
    }

private:
    static __device__ unsigned group() { return 0xffffu << (threadIdx.x & AllOfSixteen::count); }
};
#else
using OneOfSixteen = AllOfSixteen;
#endif

/// Sixteen things that a stage handles as a group. On the host an item of the stage is a group. On
/// a GPU an item is one of the things, so that threads side by side share the work.
template <class T>
class Sixteen {
public:
    static constexpr std::uint32_t count = 16;

#if defined(__CUDA_ARCH__)
    PIERCE_HD static std::uint32_t group_of(std::uint32_t item) { return item / count; }
    /// True for one of the items that handle a group, so that results for the whole group are
    /// written once.
    PIERCE_HD static bool is_first() { return threadIdx.x % count == 0; }

    /// Calls see(k, thing).
    template <class See>
    PIERCE_HD void each(const See& see) {
        see(threadIdx.x % count, mine_);
    }
    /// The k-th thing, for use within each().
    PIERCE_HD const T& at(std::uint32_t) const { return mine_; }

    /// Waits until what the other threads of the group wrote can be read.
    PIERCE_HD static void settle() { __syncwarp(group()); }

    /// The results of part(k, thing) for all sixteen, joined by join(all, part). First each of the
    /// first eight is joined with the one eight places on, then each of the first four with the one
    /// four places on, and so on. On a GPU all sixteen threads get a result; the results are the
    /// same if a join does not depend on the order of its two arguments.
    template <class All, class Part, class Join>
    PIERCE_HD All joined(const Part& part, const Join& join) const {
        All all = part(threadIdx.x % count, mine_);
        for (std::uint32_t step = count / 2; step > 0; step /= 2) {
            const All other = from_lane(all, step);
            join(all, other);
        }
        return all;
    }

private:
    /// The mask of all threads of the group; all of them must be active.
    PIERCE_HD static unsigned group() { return 0xffffu << (threadIdx.x & count); }

    template <class All>
    PIERCE_HD static All from_lane(const All& mine, std::uint32_t step) {
        constexpr std::uint32_t words = sizeof(All) / 4;
        static_assert(sizeof(All) % 4 == 0);
        std::uint32_t word[words];
        memcpy(word, &mine, sizeof(All));
        for (std::uint32_t w = 0; w < words; ++w) word[w] = __shfl_xor_sync(group(), word[w], step);
        All other;
        memcpy(&other, word, sizeof(All));
        return other;
    }

    T mine_;
#else
    static std::uint32_t group_of(std::uint32_t item) { return item; }
    static bool is_first() { return true; }
    static void settle() {}
    template <class See>
    void each(const See& see) {
        for (std::uint32_t k = 0; k < count; ++k) see(k, things_[k]);
    }
    const T& at(std::uint32_t k) const { return things_[k]; }
    template <class All, class Part, class Join>
    All joined(const Part& part, const Join& join) const {
        All all[count];
        for (std::uint32_t k = 0; k < count; ++k) all[k] = part(k, things_[k]);
        for (std::uint32_t step = count / 2; step > 0; step /= 2)
            for (std::uint32_t k = 0; k < step; ++k) join(all[k], all[k + step]);
        return all[0];
    }

private:
    T things_[count];
#endif
};

/// Calls fill(item) to write all of items[i], where threads side by side write items side by side.
/// On a GPU a warp first puts its items in order and then writes them word after word. If each
/// thread wrote its own item, every word would be a memory access that reaches a small part of a
/// line. On the host the item is filled where it lies: to copy one that was just written part by
/// part would wait for all of these writes (measured: half the time of a stage of rays).
template <class T, class Fill>
PIERCE_HD void write_side_by_side(T* items, std::uint32_t i, const Fill& fill) {
#if defined(__CUDA_ARCH__)
    T value;
    fill(value);
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
    fill(items[i]);
#endif
}

}  // namespace pierce
