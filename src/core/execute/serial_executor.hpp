#pragma once

#include <algorithm>

#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/execute/host_executor.hpp"
#include "core/execute/host_sort.hpp"
#include "core/execute/list_length.hpp"
#include "core/execute/stage_traits.hpp"

namespace pierce {

/// Runs one item after the other on the calling thread; the other executors are compared with this
/// one.
class SerialExecutor : public HostExecutor {
public:
    template <class F>
    void for_each(std::uint32_t n, const F& stage) {
        for (std::uint32_t i = 0; i < n; ++i) stage(i);
    }

    template <class... F>
    void in_turn(std::uint32_t n, const F&... stages) {
        (for_each(n, stages), ...);
    }

    /// out[i] = in[0] + ... + in[i-1]; returns the total.
    std::uint32_t exclusive_scan(ListId, std::uint32_t n, View<const std::uint32_t> in,
                                 View<std::uint32_t> out) {
        std::uint64_t sum = 0;
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t value = in[i];
            out[i] = static_cast<std::uint32_t>(sum);
            sum += value;
        }
        return list_length(sum);
    }

    /// Lists the items for which `wanted(item)` holds, in order; returns how many there are. `out`
    /// has room for all.
    template <class F>
    std::uint32_t select(ListId, std::uint32_t n, const F& wanted, View<std::uint32_t> out) {
        std::uint32_t count = 0;
        for (std::uint32_t i = 0; i < n; ++i) {
            const bool take = wanted(i);
            out[count] = listed(wanted, i);  // written whether or not it is wanted, so that there
                                             // is no branch to predict
            count += take;
        }
        return count;
    }

    /// Lists things in the order of the items that found them.
    template <class F, class... T>
    void emit(ListId, std::uint32_t n, const F& finder, HostBuffer<T>&... lists) {
        std::uint32_t place = 0, end = 0;
        (lists.clear(), ...);
        for (std::uint32_t i = 0; i < n; ++i, place = end) {
            const auto found = finder.find(i);
            end = list_length(std::uint64_t{place} + finder.count(found));
            (lists.resize(end), ...);
            finder.write(i, found, place, lists.data()...);
        }
    }

    /// Sorts keys by their lowest `bits` bits, and their values with them; stable. Any key's higher
    /// bits must be zero, or all its bits must be ones.
    void sort(std::uint32_t n, int, View<const std::uint64_t> keys,
              View<const std::uint32_t> values, View<std::uint64_t> sorted_keys,
              View<std::uint32_t> sorted_values) {
        std::copy_n(keys.data, n, sorted_keys.data);
        std::copy_n(values.data, n, sorted_values.data);
        sort_({sorted_keys.data, n}, {sorted_values.data, n});
    }

    /// sum[0] = term(0) + ... + term(n - 1), a default-made T for n = 0.
    template <class F, class T>
    void reduce(std::uint32_t n, const F& term, T& sum) {
        T all{};
        for (std::uint32_t i = 0; i < n; ++i) all = all + term(i);
        sum = all;
    }

private:
    HostSort sort_;
};

static_assert(Executor<SerialExecutor>);

}  // namespace pierce
