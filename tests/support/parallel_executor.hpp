#pragma once

#include <algorithm>
#include <cstdint>
#include <execution>
#include <numeric>
#include <vector>

#include "core/execute/executor.hpp"
#include "core/execute/host_executor.hpp"
#include "core/execute/stage_traits.hpp"

namespace pierce::test {

/// Runs stages by the standard library's parallel algorithms; written from docs/new_backend.md
/// alone.
class ParallelExecutor : public HostExecutor {
public:
    template <class F>
    void for_each(std::uint32_t n, const F& stage) {
        const std::vector<std::uint32_t>& all = numbers(n);
        std::for_each(std::execution::par, all.begin(), all.begin() + n,
                      [&](std::uint32_t i) { stage(i); });
    }

    template <class... F>
    void in_turn(std::uint32_t n, const F&... stages) {
        (for_each(n, stages), ...);
    }

    std::uint32_t exclusive_scan(ListId, std::uint32_t n, View<const std::uint32_t> in,
                                 View<std::uint32_t> out) {
        if (n == 0) return 0;
        sums_.resize(n);  // `out` may be `in`
        std::inclusive_scan(std::execution::par, in.data, in.data + n, sums_.begin());
        out[0] = 0;
        std::copy_n(sums_.begin(), n - 1, out.data + 1);
        return sums_.back();
    }

    template <class F>
    std::uint32_t select(ListId id, std::uint32_t n, const F& wanted, View<std::uint32_t> out) {
        places_.resize(n + 1);
        for_each(n, [&](std::uint32_t i) { places_[i] = wanted(i); });
        const std::uint32_t total = exclusive_scan(id, n, {places_.data(), n}, {places_.data(), n});
        places_[n] = total;
        for_each(n, [&](std::uint32_t i) {
            if (places_[i + 1] > places_[i]) out[places_[i]] = listed(wanted, i);
        });
        return total;
    }

    template <class F, class... T>
    void emit(ListId id, std::uint32_t n, const F& finder, HostBuffer<T>&... lists) {
        places_.resize(n);
        for_each(n, [&](std::uint32_t i) { places_[i] = finder.count(finder.find(i)); });
        const std::uint32_t total = exclusive_scan(id, n, {places_.data(), n}, {places_.data(), n});
        (lists.resize(total), ...);
        for_each(n, [&](std::uint32_t i) {
            finder.write(i, finder.find(i), places_[i], lists.data()...);
        });
    }

    void sort(std::uint32_t n, int, View<const std::uint64_t> keys,
              View<const std::uint32_t> values, View<std::uint64_t> sorted_keys,
              View<std::uint32_t> sorted_values) {
        std::vector<std::uint32_t> order(n);
        std::iota(order.begin(), order.end(), 0u);
        std::stable_sort(std::execution::par, order.begin(), order.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
        for (std::uint32_t i = 0; i < n; ++i) {
            sorted_keys[i] = keys[order[i]];
            sorted_values[i] = values[order[i]];
        }
    }

    /// In the order of the items, so that sums of real numbers are always the same.
    template <class F, class T>
    void reduce(std::uint32_t n, const F& term, T& sum) {
        T all{};
        for (std::uint32_t i = 0; i < n; ++i) all = all + term(i);
        sum = all;
    }

private:
    /// At least n numbers from 0 on.
    const std::vector<std::uint32_t>& numbers(std::uint32_t n) {
        for (auto i = static_cast<std::uint32_t>(numbers_.size()); i < n; ++i)
            numbers_.push_back(i);
        return numbers_;
    }

    std::vector<std::uint32_t> numbers_, places_, sums_;
};

static_assert(Executor<ParallelExecutor>);

}  // namespace pierce::test
