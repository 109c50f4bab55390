#pragma once

#include <algorithm>
#include <cstdint>
#include <new>
#include <numeric>
#include <span>
#include <vector>

#include "core/execute/serial_executor.hpp"
#include "core/execute/stage_traits.hpp"

namespace pierce::test {

/// Runs a stage's items in another order every time, asks emitting stages twice and lists what they
/// find block by block, blocks in any order, and does not let items write that find nothing: what
/// an executor with many threads may do, on one thread, so that it comes again the same.
class ShuffledExecutor : public HostExecutor {
public:
    static constexpr ExecutorTraits traits{.host_reads = false,
                                           .overlaps_updates = true,
                                           .joins_stages = true,
                                           .bodies_at_once = 512,
                                           .sweep_walks = 8};

    template <class F>
    void for_each(std::uint32_t n, const F& stage) {
        for (std::uint32_t i : shuffled(n)) stage(i);
    }

    template <class... F>
    void in_turn(std::uint32_t n, const F&... stages) {
        (for_each(n, stages), ...);
    }

    std::uint32_t exclusive_scan(ListId id, std::uint32_t n, View<const std::uint32_t> in,
                                 View<std::uint32_t> out) {
        return serial_.exclusive_scan(id, n, in, out);
    }

    template <class F>
    std::uint32_t select(ListId id, std::uint32_t n, const F& wanted, View<std::uint32_t> out) {
        return serial_.select(id, n, wanted, out);
    }

    /// How many more lists there is memory for, if not null.
    std::uint32_t* lists_left = nullptr;

    template <class T>
    void assign(HostBuffer<T>& buffer, std::uint32_t count, const T& value) {
        need_memory();
        HostExecutor::assign(buffer, count, value);
    }
    template <class T>
    void upload(std::span<const T> items, HostBuffer<T>& buffer) {
        need_memory();
        HostExecutor::upload(items, buffer);
    }

    template <class F, class... T>
    void emit(ListId, std::uint32_t n, const F& finder, HostBuffer<T>&... lists) {
        need_memory();
        for (std::uint32_t i : shuffled(n)) finder.find(i);
        std::vector<std::uint32_t> blocks((n + block - 1) / block);
        std::iota(blocks.begin(), blocks.end(), 0u);
        if (!in_order<F>()) blocks = shuffled(static_cast<std::uint32_t>(blocks.size()));
        std::uint32_t place = 0;
        (lists.clear(), ...);
        for (std::uint32_t b : blocks)
            for (std::uint32_t i = b * block; i < std::min(n, (b + 1) * block); ++i) {
                const auto found = finder.find(i);
                const std::uint32_t end = place + finder.count(found);
                (lists.resize(end), ...);
                if (end > place) finder.write(i, found, place, lists.data()...);
                place = end;
            }
    }

    void sort(std::uint32_t n, int bits, View<const std::uint64_t> keys,
              View<const std::uint32_t> values, View<std::uint64_t> sorted_keys,
              View<std::uint32_t> sorted_values) {
        serial_.sort(n, bits, keys, values, sorted_keys, sorted_values);
    }

    template <class F, class T>
    void reduce(std::uint32_t n, const F& term, T& sum) {
        T all{};
        for (std::uint32_t i : shuffled(n)) all = all + term(i);
        sum = all;
    }

private:
    static constexpr std::uint32_t block = 8;

    void need_memory() {
        if (lists_left != nullptr && (*lists_left)-- == 0) throw std::bad_alloc();
    }

    /// The numbers below n: steps of a length that has no factor in common with n lead to all of
    /// them.
    std::vector<std::uint32_t> shuffled(std::uint32_t n) {
        state_ = state_ * 6364136223846793005u + 1442695040888963407u;
        std::vector<std::uint32_t> order(n);
        if (n == 0) return order;
        std::uint64_t step = (state_ >> 33) % n;
        while (std::gcd(step, std::uint64_t{n}) != 1) ++step;
        std::uint64_t at = (state_ >> 20) % n;
        for (std::uint32_t& i : order) {
            i = static_cast<std::uint32_t>(at);
            at = (at + step) % n;
        }
        return order;
    }

    SerialExecutor serial_;
    std::uint64_t state_ = 1;
};

static_assert(Executor<ShuffledExecutor>);

}  // namespace pierce::test
