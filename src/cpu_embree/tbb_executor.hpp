#pragma once

#include <tbb/task_arena.h>

#include <cstddef>
#include <new>
#include <numeric>
#include <type_traits>

#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/execute/host_executor.hpp"
#include "core/execute/serial_executor.hpp"
#include "core/execute/stage_traits.hpp"
#include "cpu_embree/team.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// Runs stages on oneTBB's threads, in an arena of its own. Items are independent and every result
/// has its own place, so results are the same for any number of threads.
class TbbExecutor : public HostExecutor {
public:
    explicit TbbExecutor(int threads) : arena_(threads), team_(arena_, threads) {}

    /// Runs the work inside the arena, so that parallel work of libraries takes no more threads
    /// either.
    template <class Work>
    void run(const Work& work) {
        arena_.execute(work);
    }

    template <class F>
    void for_each(std::uint32_t n, const F& stage) {
        constexpr std::uint32_t grain = is_cheap<F>() ? cheap_grain : usual_grain;
        if (n <= grain) return serial_.for_each(n, stage);
        share(n, grain, stage);
    }

    template <class... F>
    void in_turn(std::uint32_t n, const F&... stages) {
        (for_each(n, stages), ...);
    }

    /// Like for_each, for few items with enough work for a task each.
    template <class F>
    void for_each_task(std::uint32_t n, const F& task) {
        if (n > 0) share(n, 1, task);
    }

    /// Runs serially: adding up a step's counts takes microseconds.
    std::uint32_t exclusive_scan(ListId id, std::uint32_t n, View<const std::uint32_t> in,
                                 View<std::uint32_t> out) {
        return serial_.exclusive_scan(id, n, in, out);
    }

    /// Runs serially: an item takes one or two nanoseconds.
    template <class F>
    std::uint32_t select(ListId id, std::uint32_t n, const F& wanted, View<std::uint32_t> out) {
        return serial_.select(id, n, wanted, out);
    }

    /// Lists things in the order of the items that found them: chunks of items first find their
    /// things and then write them.
    template <class F, class... T>
    void emit(ListId id, std::uint32_t n, const F& finder, HostBuffer<T>&... lists) {
        if (n <= emitted_chunk) return serial_.emit(id, n, finder, lists...);
        using Seen = decltype(finder.find(0));
        static_assert(std::is_trivially_copyable_v<Seen> &&
                      alignof(Seen) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
        found_.renew(n * sizeof(Seen));
        Seen* const found = reinterpret_cast<Seen*>(found_.data());
        places_.resize((n + emitted_chunk - 1) / emitted_chunk + 1);
        const auto chunks = static_cast<std::uint32_t>(places_.size() - 1);
        share(chunks, 1, [&](std::uint32_t chunk) {
            const std::uint32_t begin = chunk * emitted_chunk,
                                end = min_of(begin + emitted_chunk, n);
            find_all(finder, begin, end, found + begin);
            std::uint64_t sum = 0;
            for (std::uint32_t i = begin; i < end; ++i) sum += finder.count(found[i]);
            places_[chunk + 1] = sum;
        });
        places_[0] = 0;
        std::partial_sum(places_.begin(), places_.end(), places_.begin());
        [[maybe_unused]] const std::uint32_t length = list_length(places_.back());
        (lists.renew(length), ...);
        share(chunks, 1, [&](std::uint32_t chunk) {
            auto place = static_cast<std::uint32_t>(places_[chunk]);
            for (std::uint32_t i = chunk * emitted_chunk;
                 i < min_of((chunk + 1) * emitted_chunk, n); ++i) {
                finder.write(i, found[i], place, lists.data()...);
                place += finder.count(found[i]);
            }
        });
    }

    /// Runs serially: there are few keys.
    void sort(std::uint32_t n, int bits, View<const std::uint64_t> keys,
              View<const std::uint32_t> values, View<std::uint64_t> sorted_keys,
              View<std::uint32_t> sorted_values) {
        serial_.sort(n, bits, keys, values, sorted_keys, sorted_values);
    }

    /// Adds up each chunk of items, and then the chunks in their order. The chunks are the same for
    /// any number of threads.
    template <class F, class T>
    void reduce(std::uint32_t n, const F& term, T& sum) {
        constexpr std::uint32_t chunk_size = is_cheap<F>() ? 8 * cheap_grain : usual_grain;
        if (n <= chunk_size) return serial_.reduce(n, term, sum);
        static_assert(std::is_trivially_copyable_v<T> &&
                      alignof(T) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
        const std::uint32_t chunks = (n + chunk_size - 1) / chunk_size;
        found_.resize(chunks * sizeof(T));
        T* const sums = reinterpret_cast<T*>(found_.data());
        share(chunks, 1, [&](std::uint32_t chunk) {
            T& all = *new (sums + chunk) T{};
            for (std::uint32_t i = chunk * chunk_size; i < min_of((chunk + 1) * chunk_size, n); ++i)
                all = all + term(i);
        });
        serial_.reduce(
            chunks, [&](std::uint32_t chunk) { return sums[chunk]; }, sum);
    }

private:
    // The least number of items per task; smaller tasks cost more than they gain by balance.
    static constexpr std::uint32_t usual_grain = 16;
    static constexpr std::uint32_t cheap_grain = 512;
    static constexpr std::uint32_t emitted_chunk = 32;

    template <class F>
    void share(std::uint32_t n, std::uint32_t grain, const F& item) {
        team_.share(n, grain, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t i = begin; i != end; ++i) item(i);
        });
    }

    tbb::task_arena arena_;
    Team team_;
    SerialExecutor serial_;
    HostBuffer<std::byte> found_;       ///< what items find while they emit, or sums of chunks
    HostBuffer<std::uint64_t> places_;  ///< where each chunk begins to write
};

static_assert(Executor<TbbExecutor>);

}  // namespace pierce
