#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pierce/core/host_sort.hpp"
#include "pierce/core/view.hpp"

namespace pierce {

namespace detail {
struct AnyStage {
    PIERCE_HD void operator()(std::uint32_t) const {}
};
struct AnyWork {
    void operator()() const {}
};
struct AnyTest {
    PIERCE_HD bool operator()(std::uint32_t) const { return true; }
};
struct AnyFinder {
    PIERCE_HD bool find(std::uint32_t) const { return true; }
    PIERCE_HD static std::uint32_t count(bool found) { return found; }
    PIERCE_HD void write(std::uint32_t, bool, std::uint32_t, float*) const {}
};
struct AnySum {
    PIERCE_HD friend AnySum operator+(AnySum, AnySum) { return {}; }
};
struct AnyTerm {
    PIERCE_HD AnySum operator()(std::uint32_t) const { return {}; }
};
}  // namespace detail

/// Runs stages over independent items and provides the few collective operations the step needs. Results never depend
/// on how work is spread. The name of an operation is for profilers.
template <class E>
concept Executor = requires(E executor, typename E::Count n, View<const std::uint32_t> in, View<std::uint32_t> out,
                            View<std::uint64_t> keys, typename E::template Buffer<float> list,
                            typename E::template Sum<detail::AnySum> sum) {
    // How many items there are: a number, or something that stands for one known elsewhere. Buffers are resized to a count,
    // and count_of(buffer) is that.
    typename E::Count;
    typename E::template Buffer<float>;
    { E::runs_on_host } -> std::convertible_to<bool>;
    executor.for_each("stage", n, detail::AnyStage{});
    // Stages of the same items, one after the other: what they read of the others' they read of their own item.
    executor.in_turn("stage", n, detail::AnyStage{}, detail::AnyStage{});
    { executor.exclusive_scan("stage", n, in, out) } -> std::same_as<typename E::Count>;
    { executor.select("stage", n, detail::AnyTest{}, out) } -> std::same_as<typename E::Count>;
    // A list of what a stage finds, or several lists side by side: of each item `count(find(item))` things, which
    // `write(item, found, place, lists...)` puts at places from `place` on. What comes first in the list nobody knows,
    // unless the stage says that things are to be in the order of their items: `static constexpr bool in_order = true`. It
    // may then say, too, what is to be in the lists past the last thing, where they have more room: `pad(place, lists...)`.
    // An item may be asked twice what it finds: what it writes meanwhile is the same then.
    executor.emit("stage", n, detail::AnyFinder{}, list);
    executor.sort("stage", n, 64, keys, in, keys, out);
    // A sum of what a stage says of its items; the stage is asked once about each.
    executor.reduce("stage", n, detail::AnyTerm{}, sum);
    { executor.read(sum) } -> std::same_as<detail::AnySum>;
    { executor.number(n) } -> std::same_as<std::uint32_t>;
    // True for so few groups of sixteen that threads are left for a thread each of the sixteen.
    { executor.are_few_sixteens(n) } -> std::same_as<bool>;
    { executor.in_sixteens(n) } -> std::same_as<typename E::Count>;
    executor.settle();
    executor.beside(detail::AnyWork{});
    executor.join();
};

/// A vector whose new elements are left as they are: every stage writes all it reads.
template <class T>
struct UninitializedAllocator : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = UninitializedAllocator<U>;
    };
    template <class U>
    void construct(U* p) noexcept {
        ::new (static_cast<void*>(p)) U;
    }
    template <class U, class... Args>
    void construct(U* p, Args&&... args) {
        ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
    }
};

template <class T>
using HostBuffer = std::vector<T, UninitializedAllocator<T>>;

template <class T>
std::uint32_t count_of(const HostBuffer<T>& buffer) {
    return static_cast<std::uint32_t>(buffer.size());
}

/// True for a stage that says its items take a few nanoseconds each: `static constexpr bool is_cheap = true`. Executors
/// then hand out many at once.
template <class Stage>
constexpr bool is_cheap() {
    if constexpr (requires { Stage::is_cheap; })
        return Stage::is_cheap;
    else
        return false;
}

/// What select() lists of an item that is wanted: the item, unless the test has something else to say, `listed(item)`.
template <class F>
PIERCE_HD std::uint32_t listed(const F& wanted, std::uint32_t i) {
    if constexpr (requires { wanted.listed(i); })
        return wanted.listed(i);
    else
        return i;
}

/// Emits what another stage finds of an item, after a stage that sees to the item first.
template <class First, class Finder>
struct FindAfter {
    First first;
    Finder finder;

    FindAfter(const First& before, const Finder& after) : first(before), finder(after) {}
    PIERCE_HD auto find(std::uint32_t i) const {
        first(i);
        return finder.find(i);
    }
    template <class Found>
    PIERCE_HD static std::uint32_t count(const Found& found) {
        return Finder::count(found);
    }
    template <class Found, class... T>
    PIERCE_HD void write(std::uint32_t i, const Found& found, std::uint32_t place, T*... lists) const {
        finder.write(i, found, place, lists...);
    }
};

/// What executors on the host have in common: counts are numbers, buffers are vectors, sums are values.
class HostExecutor {
public:
    using Count = std::uint32_t;
    template <class T>
    using Buffer = HostBuffer<T>;
    template <class T>
    using Sum = T;
    static constexpr bool runs_on_host = true;

    /// What a reduction came to.
    template <class T>
    T read(const T& sum) const {
        return sum;
    }

    /// How many items has a stage that sees to so many groups (Sixteen).
    std::uint32_t in_sixteens(std::uint32_t groups) const { return groups; }

    /// An item of the host sees to all of a group.
    bool are_few_sixteens(std::uint32_t) const { return false; }

    /// A count as a number.
    std::uint32_t number(std::uint32_t count) const { return count; }

    template <class T>
    void assign(HostBuffer<T>& buffer, std::uint32_t count, const T& value) {
        buffer.assign(count, value);
    }

    /// Work that consists of stages, as a whole.
    template <class Work>
    void run(const Work& work) {
        work();
    }

    /// Stages are over when their call is.
    void settle() const {}

    /// Work that needs nothing of what comes until join(), nor is needed by it.
    template <class Work>
    void beside(const Work& work) {
        work();
    }
    void join() {}

    template <class T>
    T first(const HostBuffer<T>& buffer) const {
        return buffer[0];
    }

    template <class T>
    std::vector<T> download(const HostBuffer<T>& buffer) const {
        return {buffer.begin(), buffer.end()};
    }

    template <class T>
    void upload(std::span<const T> items, HostBuffer<T>& buffer) {
        buffer.assign(items.begin(), items.end());
    }
};

/// One item after the other, on the calling thread: the reference the other executors are compared with.
class SerialExecutor : public HostExecutor {
public:
    template <class F>
    void for_each(const char*, std::uint32_t n, const F& stage) {
        for (std::uint32_t i = 0; i < n; ++i) stage(i);
    }

    template <class... F>
    void in_turn(const char* name, std::uint32_t n, const F&... stages) {
        (for_each(name, n, stages), ...);
    }

    /// out[i] = in[0] + ... + in[i-1]; returns the total.
    std::uint32_t exclusive_scan(const char*, std::uint32_t n, View<const std::uint32_t> in, View<std::uint32_t> out) {
        std::uint32_t sum = 0;
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t value = in[i];
            out[i] = sum;
            sum += value;
        }
        return sum;
    }

    /// Lists the items for which `wanted(item)` holds, in order; returns how many there are. `out` has room for all.
    template <class F>
    std::uint32_t select(const char*, std::uint32_t n, const F& wanted, View<std::uint32_t> out) {
        std::uint32_t count = 0;
        for (std::uint32_t i = 0; i < n; ++i) {
            const bool take = wanted(i);
            out[count] = listed(wanted, i);  // before it is known whether it stays: no branch to predict
            count += take;
        }
        return count;
    }

    /// Things in the order of the items that they were found by.
    template <class F, class... T>
    void emit(const char*, std::uint32_t n, const F& finder, HostBuffer<T>&... lists) {
        std::uint32_t place = 0, end = 0;
        (lists.clear(), ...);
        for (std::uint32_t i = 0; i < n; ++i, place = end) {
            const auto found = finder.find(i);
            end = place + finder.count(found);
            (lists.resize(end), ...);
            finder.write(i, found, place, lists.data()...);
        }
    }

    /// Sorts keys by their lowest `bits` bits, and their values with them; stable. Any key's higher bits must be zero, or
    /// all its bits must be ones.
    void sort(const char*, std::uint32_t n, int, View<const std::uint64_t> keys, View<const std::uint32_t> values,
              View<std::uint64_t> sorted_keys, View<std::uint32_t> sorted_values) {
        std::copy_n(keys.data, n, sorted_keys.data);
        std::copy_n(values.data, n, sorted_values.data);
        sort_({sorted_keys.data, n}, {sorted_values.data, n});
    }

    /// sum[0] = term(0) + ... + term(n - 1), default-made for none.
    template <class F, class T>
    void reduce(const char*, std::uint32_t n, const F& term, T& sum) {
        T all{};
        for (std::uint32_t i = 0; i < n; ++i) all = all + term(i);
        sum = all;
    }

private:
    HostSort sort_;
};

static_assert(Executor<SerialExecutor>);

}  // namespace pierce
