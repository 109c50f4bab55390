#pragma once

#include "gpu_cuda/stage_kernels.cuh"
#include "pierce/min_max.hpp"

/// The sort of short lists, in one launch.
namespace pierce::cuda {

/// Lists up to this long are sorted by counting, for each key, the keys that come before it. That
/// uses the whole GPU at once, where a sort by passes waits for one launch after the other. Chunks
/// of keys are counted as a whole where possible; in a nearly sorted list, such as contacts, those
/// are most of them.
inline constexpr std::uint32_t counted_list = 1u << 14;
inline constexpr std::uint32_t counted_keys = 64, counted_parts = 16;  ///< keys of a block, and
                                                                       ///< threads that share a key
inline constexpr std::uint32_t counted_chunk = 64, most_chunks = counted_list / counted_chunk;

/// Keys, and the smallest and the largest key of each chunk. A list so short that every thread has
/// one chunk does without the chunks' limits and is counted key by key.
struct KeyChunks {
    const std::uint64_t* keys;
    std::uint32_t count;
    std::uint64_t *lowest, *highest;  ///< per chunk, shared by the block

    __device__ bool is_short() const { return count <= counted_parts * counted_chunk; }
    __device__ std::uint32_t chunk_size() const {
        return is_short() ? (count + counted_parts - 1) / counted_parts : counted_chunk;
    }
    __device__ std::uint32_t size() const {
        return count == 0 ? 0 : (count + chunk_size() - 1) / chunk_size();
    }

    /// Finds the limits of a chunk; one warp calls it.
    __device__ void measure(std::uint32_t chunk) const {
        std::uint64_t low = ~std::uint64_t{0}, high = 0;
        const std::uint32_t end = min_of((chunk + 1) * counted_chunk, count);
        for (std::uint32_t k = chunk * counted_chunk + threadIdx.x % warp_threads; k < end;
             k += warp_threads) {
            low = min_of(keys[k], low);
            high = max_of(keys[k], high);
        }
        for (std::uint32_t step = warp_threads / 2; step > 0; step /= 2) {
            low = min_of(std::uint64_t{__shfl_xor_sync(0xffffffffu, low, step)}, low);
            high = max_of(std::uint64_t{__shfl_xor_sync(0xffffffffu, high, step)}, high);
        }
        lowest[chunk] = low;
        highest[chunk] = high;
    }

    /// The number of a chunk's keys that come before the key of place i; of equal keys, those at
    /// smaller places come before it.
    __device__ std::uint32_t before(std::uint32_t chunk, std::uint64_t key, std::uint32_t i) const {
        const std::uint32_t begin = chunk * chunk_size(), end = min_of(begin + chunk_size(), count);
        if (!is_short()) {
            if (highest[chunk] < key || (highest[chunk] == key && end <= i)) return end - begin;
            if (lowest[chunk] > key || (lowest[chunk] == key && begin > i)) return 0;
        }
        const std::uint32_t middle = min_of(max_of(i, begin), end);
        std::uint32_t sum = 0;
#pragma unroll 8
        for (std::uint32_t k = begin; k < middle; ++k) sum += keys[k] <= key;
#pragma unroll 8
        for (std::uint32_t k = middle; k < end; ++k) sum += keys[k] < key;
        return sum;
    }
};

/// Writes keys and their values to their sorted places; the sort is stable. Places past the last
/// key get the largest key.
inline __global__ void __launch_bounds__(counted_keys* counted_parts)
    sort_by_counting(const Items items, const std::uint64_t* keys, const std::uint32_t* values,
                     std::uint64_t* sorted_keys, std::uint32_t* sorted_values) {
    __shared__ std::uint32_t before[counted_keys];
    __shared__ std::uint64_t lowest[most_chunks], highest[most_chunks];
    const std::uint32_t mine = threadIdx.x % counted_keys, i = blockIdx.x * counted_keys + mine;
    const std::uint32_t part = threadIdx.x / counted_keys;
    const KeyChunks chunks{
        .keys = keys, .count = items.count(), .lowest = lowest, .highest = highest};
    if (part == 0) before[mine] = 0;
    if (!chunks.is_short())
        for (std::uint32_t c = threadIdx.x / warp_threads; c < chunks.size();
             c += blockDim.x / warp_threads)
            chunks.measure(c);
    __syncthreads();
    const std::uint64_t key = i < chunks.count ? keys[i] : 0;
    if (i < chunks.count) {
        std::uint32_t sum = 0;
        for (std::uint32_t c = part; c < chunks.size(); c += counted_parts)
            sum += chunks.before(c, key, i);
        atomicAdd(&before[mine], sum);
    }
    __syncthreads();
    if (part != 0 || i >= items.bound) return;
    const std::uint32_t place = i < chunks.count ? before[mine] : i;
    sorted_keys[place] = i < chunks.count ? key : ~std::uint64_t{0};
    sorted_values[place] = values[i];
}

}  // namespace pierce::cuda
