#pragma once

#include <cuda_runtime.h>

#include <cub/block/block_reduce.cuh>
#include <cub/block/block_scan.cuh>

#include "pierce/core/executor.hpp"
#include "pierce/core/float_rules.hpp"
#include "pierce/core/warp.hpp"
#include "pierce/gpu_cuda/device_count.hpp"

/// What the executor launches: a thread an item, lists continued past their end for CUB, and short lists scanned, selected
/// from by one block, and sorted by counting.
namespace pierce::cuda {

/// Threads of a block. Few items spread over more multiprocessors in small blocks; of many, small ones would keep the GPU
/// waiting for the next block to start: one starts in about 0.7 ns.
inline constexpr std::uint32_t few_threads = 64, block_threads = block_warps * warp_threads, many_items = 1u << 18;

/// Items from which those who emit a list come in large blocks: small ones would wait for each other.
inline constexpr std::uint32_t many_emitting = 1u << 15;

/// So few items have their stages in one launch: it takes their thread all registers that one of them asks for, but all
/// items are under way at once all the same.
inline constexpr std::uint32_t few_items = 1u << 15;

/// Groups of sixteen up to which a thread each of the sixteen pays: they all run at once.
inline constexpr std::uint32_t few_sixteens = 1u << 13;

/// Lists up to this long are scanned and selected from by one block: launches cost more than the work.
inline constexpr std::uint32_t short_list = 1u << 14;

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
/// say how many threads (`static constexpr int threads_at_once`).
template <class F>
constexpr int blocks_at_once() {
    if constexpr (requires { F::threads_at_once; })
        return F::threads_at_once / static_cast<int>(block_threads);
    else
        return 1;
}

/// True for a stage whose threads take very different times (`static constexpr bool is_uneven = true`): a small block makes
/// room for the next one sooner.
template <class F>
constexpr bool is_uneven() {
    if constexpr (requires { F::is_uneven; })
        return F::is_uneven;
    else
        return false;
}

/// Stages one after the other, by the same thread.
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
__global__ void __launch_bounds__(block_threads, blocks_at_once<F>())
    run_stage(const __grid_constant__ F stage, const Items items) {
    const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < items.count()) stage(i);
}

/// What the blocks of a launch add up to, a word for each: its own sum at first, then that of all up to it. A word is read
/// and written whole. `epoch` differs from launch to launch, so that words of earlier ones need not be cleared.
struct BlockSums {
    std::uint64_t* words;
    const std::uint32_t* epoch;

    /// By a whole warp: what the blocks before this one add up to, whose own sum is `sum`. They are looked back for, a warp
    /// of them at a time, until one knows the sum of all before it (Merrill and Garland 2016, decoupled look-back). Blocks
    /// start in their order, so those waited for are under way.
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
    __device__ void write(std::uint32_t block, std::uint32_t now, bool is_of_all, std::uint32_t sum) const {
        static_cast<volatile std::uint64_t*>(words)[block] = std::uint64_t{now} << 33 | std::uint64_t{is_of_all} << 32 | sum;
    }
};

/// Per total: none so far. Begins a launch that emits a list, or several with words and totals of their own. No epoch is
/// zero, which is what new words are.
struct BeginLists {
    std::uint32_t* totals;
    std::uint32_t* epoch;

    __device__ void operator()(std::uint32_t i) const {
        totals[i] = 0;
        if (i == 0) *epoch = max_of((*epoch + 1) & 0x7fffffffu, 1u);
    }
};

/// How much room there is for what items find, and where it is said how many things there are: also if there is not room.
struct Emitted {
    std::uint32_t room;
    std::uint32_t* total;  ///< zero at first
    std::uint32_t* overflow;
    BlockSums sums;
    bool in_order;
};

/// Blocks up to which what they find is listed in order, also where nobody asks: contacts of a list that is nearly sorted
/// are sooner sorted. A block waits for those before it, which takes longer than the work where they are many.
inline constexpr std::uint32_t few_blocks = 512;

/// True for a stage whose list is in the order of its items in any case (`static constexpr bool in_order = true`).
template <class F>
constexpr bool in_order() {
    if constexpr (requires { F::in_order; })
        return F::in_order;
    else
        return false;
}

/// Writes what items find; nothing by a block for which there is not room enough. Without lists things are only counted.
template <class F, class... T>
__global__ void __launch_bounds__(block_threads, blocks_at_once<F>())
    emit_stage(const __grid_constant__ F finder, const Items items, const Emitted to, T* const... lists) {
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
            if (sum > 0 && before + sum > to.room) *to.overflow = 1;
        }
    }
    __syncthreads();
    if constexpr (sizeof...(T) > 0)
        if (is_item && sum > 0 && begin + sum <= to.room) finder.write(i, found, begin + place, lists...);
    if constexpr (requires { finder.pad(i, lists...); }) {
        static_assert(in_order<F>(), "the last block knows where the list ends");
        if (blockIdx.x + 1 == gridDim.x)
            for (std::uint32_t k = begin + sum + threadIdx.x; k < to.room; k += blockDim.x) finder.pad(k, lists...);
    }
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

template <class F>
struct WantedAt {
    Items items;
    F wanted;

    __device__ bool operator()(std::uint32_t i) const { return i < items.count() && wanted(i); }
};

/// What is listed of an item that is wanted.
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

/// A total: of a scan, or how many a selection has listed. No more than there is room for is kept; `overflow` says if there
/// was not.
struct NoteTotal {
    std::uint32_t room;
    std::uint32_t* total;
    std::uint32_t* overflow;

    __device__ void note(std::uint32_t sum) const {
        *total = min_of(sum, room);
        if (sum > room) *overflow = 1;
    }
    __device__ void operator()(std::ptrdiff_t, std::uint32_t sum) const { note(sum); }
};

/// Where a scan writes to; with the last place it notes the total.
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

/// Adds up the terms of all items, in an order that depends on nothing but the launch: every block those of its threads, and
/// the last one to be done the sums of all blocks. `done`: how many blocks are; zero before and after.
template <std::uint32_t threads, class F, class T>
__global__ void __launch_bounds__(threads)
    add_up(const __grid_constant__ F term, const Items items, T* sums, std::uint32_t* done, T* total) {
    using Reduce = cub::BlockReduce<T, threads>;
    __shared__ typename Reduce::TempStorage scratch;
    __shared__ bool is_last;
    const std::uint32_t count = items.count();
    T sum{};
    for (std::uint32_t i = blockIdx.x * threads + threadIdx.x; i < count; i += gridDim.x * threads) sum = sum + term(i);
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

/// An exclusive scan by one block, which notes the total, too.
inline __global__ void __launch_bounds__(scan_threads)
    scan_short_list(const CountAt in, std::uint32_t* out, const NoteTotal to) {
    using Scan = cub::BlockScan<std::uint32_t, scan_threads, cub::BLOCK_SCAN_WARP_SCANS>;
    __shared__ typename Scan::TempStorage scratch;
    const std::uint32_t count = in.items.count();
    std::uint32_t sum = 0;
    for (std::uint32_t begin = 0; begin < count; begin += scan_threads * scan_items) {
        const std::uint32_t first = begin + threadIdx.x * scan_items;
        std::uint32_t items[scan_items];  // read without asking for the list's length each time
        for (std::uint32_t k = 0; k < scan_items; ++k) items[k] = first + k < count ? in.in[first + k] : 0;
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
    using Scan = cub::BlockScan<std::uint32_t, scan_threads, cub::BLOCK_SCAN_WARP_SCANS>;
    __shared__ typename Scan::TempStorage scratch;
    const std::uint32_t count = wanted.items.count();
    std::uint32_t sum = 0;
    for (std::uint32_t begin = 0; begin < count; begin += scan_threads * scan_items) {
        const std::uint32_t first = begin + threadIdx.x * scan_items;
        std::uint32_t takes = 0;  // a bit an item
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

/// Lists up to this long are sorted by counting for each key those before it, on all of the GPU at once, where a sort by
/// passes waits for one launch after the other. Chunks of keys count as a whole where they can: most of them where a list is
/// nearly sorted, as contacts are.
inline constexpr std::uint32_t counted_list = 1u << 14;
inline constexpr std::uint32_t counted_keys = 64, counted_parts = 16;  ///< keys of a block, and threads that share a key
inline constexpr std::uint32_t counted_chunk = 64, most_chunks = counted_list / counted_chunk;

/// Keys, and the first and the last of each chunk in their order. A list so short that every thread has one chunk goes
/// without: it is counted key by key.
struct KeyChunks {
    const std::uint64_t* keys;
    std::uint32_t count;
    std::uint64_t *lowest, *highest;  ///< per chunk, shared by the block

    __device__ bool is_short() const { return count <= counted_parts * counted_chunk; }
    __device__ std::uint32_t chunk_size() const {
        return is_short() ? (count + counted_parts - 1) / counted_parts : counted_chunk;
    }
    __device__ std::uint32_t size() const { return count == 0 ? 0 : (count + chunk_size() - 1) / chunk_size(); }

    /// By one warp.
    __device__ void measure(std::uint32_t chunk) const {
        std::uint64_t low = ~std::uint64_t{0}, high = 0;
        const std::uint32_t end = min_of((chunk + 1) * counted_chunk, count);
        for (std::uint32_t k = chunk * counted_chunk + threadIdx.x % warp_threads; k < end; k += warp_threads) {
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

    /// How many of a chunk's keys come before that of place i; of equal ones those at smaller places.
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

/// Writes keys and their values to where they belong; stable. What is past the last key becomes the largest.
inline __global__ void __launch_bounds__(counted_keys* counted_parts)
    sort_by_counting(const Items items, const std::uint64_t* keys, const std::uint32_t* values, std::uint64_t* sorted_keys,
                     std::uint32_t* sorted_values) {
    __shared__ std::uint32_t before[counted_keys];
    __shared__ std::uint64_t lowest[most_chunks], highest[most_chunks];
    const std::uint32_t mine = threadIdx.x % counted_keys, i = blockIdx.x * counted_keys + mine;
    const std::uint32_t part = threadIdx.x / counted_keys;
    const KeyChunks chunks{keys, items.count(), lowest, highest};
    if (part == 0) before[mine] = 0;
    if (!chunks.is_short())
        for (std::uint32_t c = threadIdx.x / warp_threads; c < chunks.size(); c += blockDim.x / warp_threads)
            chunks.measure(c);
    __syncthreads();
    const std::uint64_t key = i < chunks.count ? keys[i] : 0;
    if (i < chunks.count) {
        std::uint32_t sum = 0;
        for (std::uint32_t c = part; c < chunks.size(); c += counted_parts) sum += chunks.before(c, key, i);
        atomicAdd(&before[mine], sum);
    }
    __syncthreads();
    if (part != 0 || i >= items.bound) return;
    const std::uint32_t place = i < chunks.count ? before[mine] : i;
    sorted_keys[place] = i < chunks.count ? key : ~std::uint64_t{0};
    sorted_values[place] = values[i];
}

}  // namespace pierce::cuda
