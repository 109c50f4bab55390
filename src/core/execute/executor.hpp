#pragma once

#include <concepts>
#include <cstdint>
#include <span>
#include <vector>

#include "core/device/view.hpp"
#include "core/execute/executor_traits.hpp"
#include "core/execute/list_id.hpp"

namespace pierce {

namespace detail {
struct AnyStage {
    PIERCE_HD void operator()(std::uint32_t) const {}
};
struct AnyWork {
    void operator()() const {}
};
template <class Count>
struct AnyNumber {
    Count operator()() const { return 0u; }
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

/// Runs stages over independent items and provides the few collective operations the step needs.
/// Results never depend on how the work is shared out.
template <class E>
concept Executor = requires(E executor, typename E::Count n, View<const std::uint32_t> in,
                            View<std::uint32_t> out, View<std::uint64_t> keys,
                            typename E::template Buffer<float> list,
                            typename E::template Sum<detail::AnySum> sum) {
    // How many items there are: a number, or something that stands for a number known elsewhere.
    // Buffers are resized to a count, and count_of(buffer) returns it.
    typename E::Count;
    typename E::template Buffer<float>;
    { E::traits } -> std::convertible_to<ExecutorTraits>;
    executor.for_each(n, detail::AnyStage{});
    // Runs stages over the same items, one after the other. A stage may read an earlier one's
    // output only at its own index.
    executor.in_turn(n, detail::AnyStage{}, detail::AnyStage{});
    { executor.exclusive_scan(ListId{}, n, in, out) } -> std::same_as<typename E::Count>;
    { executor.select(ListId{}, n, detail::AnyTest{}, out) } -> std::same_as<typename E::Count>;
    // Makes a list of what a stage finds, or several lists side by side. Each item adds
    // `count(find(item))` things, which `write(item, found, place, lists...)` puts at places from
    // `place` on; it may be left out for an item that adds nothing. The order of things in a list
    // is unspecified unless the stage asks for the order of their items: `static constexpr bool
    // in_order = true`. Such a stage may also fill the lists past the last thing, where they have
    // more room: `pad(place, lists...)`. `find` may be called twice for an item; what it writes
    // must be the same both times.
    executor.emit(ListId{}, n, detail::AnyFinder{}, list);
    executor.sort(n, 64, keys, in, keys, out);
    // Adds up a term for every item; the stage is called once for each.
    executor.reduce(n, detail::AnyTerm{}, sum);
    { executor.read(sum) } -> std::same_as<detail::AnySum>;
    { executor.number(n) } -> std::same_as<std::uint32_t>;
    { executor.times(2, n) } -> std::same_as<typename E::Count>;
    // True for so few groups of sixteen that there are enough threads for each of the sixteen.
    { executor.are_few_sixteens(n) } -> std::same_as<bool>;
    { executor.in_sixteens(n) } -> std::same_as<typename E::Count>;
    { executor.in_lanes(n) } -> std::same_as<typename E::Count>;
    // True for so few things that there are enough threads for lanes of each.
    { executor.are_few_in_lanes(n) } -> std::same_as<bool>;
    // True if there certainly are no items: where the host does not know it, there may be some.
    { executor.is_empty(n) } -> std::same_as<bool>;
    // Runs work that does nothing if the test holds for no item, and may leave it out then. Lists
    // that the work makes are empty if it is left out.
    executor.when_any(n, detail::AnyTest{}, detail::AnyWork{});
    // Runs work again and again until no items are left.
    executor.repeat(ListId{}, detail::AnyNumber<typename E::Count>{}, detail::AnyWork{});
    executor.settle();
    // Runs work that is independent of everything issued before join(); the work may run
    // concurrently.
    executor.beside(detail::AnyWork{});
    executor.join();
    // What is issued from now on may read the positions of ghosts, which come from other parts.
    executor.await_ghosts();
    // Runs work that consists of stages as a whole: a step, or rays outside of a step.
    executor.run(detail::AnyWork{});
    // Fill a list with a value, copy a list from the host, and copy it to the host.
    executor.assign(list, n, 0.0f);
    executor.upload(std::span<const float>{}, list);
    { executor.download(list) } -> std::same_as<std::vector<float>>;
};

}  // namespace pierce
