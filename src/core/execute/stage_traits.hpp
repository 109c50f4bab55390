#pragma once

#include <cstdint>
#include <new>

#include "pierce/host_device.hpp"

/// What a stage may declare for executors, and how executors use it.
namespace pierce {

/// Stands for a stage where there is none.
struct NoStage {
    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t) const {}
};
template <class Stage>
inline constexpr bool is_no_stage = false;
template <>
inline constexpr bool is_no_stage<NoStage> = true;

/// True for a stage that declares that its items take a few nanoseconds each: `static constexpr
/// bool is_cheap = true`. Executors then hand out many items at once.
template <class Stage>
constexpr bool is_cheap() {
    if constexpr (requires { Stage::is_cheap; })
        return Stage::is_cheap;
    else
        return false;
}

/// True for a stage whose list must be in the order of its items (`static constexpr bool in_order =
/// true`).
template <class F>
constexpr bool in_order() {
    if constexpr (requires { F::in_order; })
        return F::in_order;
    else
        return false;
}

/// True for a stage whose lanes meet in a Room (`static constexpr bool has_rooms = true`). A GPU
/// runs it in blocks of room_threads.
template <class Stage>
constexpr bool has_rooms() {
    if constexpr (requires { Stage::has_rooms; })
        return Stage::has_rooms;
    else
        return false;
}

/// Puts what a stage finds for the items from `begin` to `end` where `found` points to. A stage may
/// have a function of its own for that, `find_all(begin, end, found)`, where on the host items take
/// less time together than one by one. It may leave out what a later stage would leave out, too.
template <class F, class Found>
void find_all(const F& finder, std::uint32_t begin, std::uint32_t end, Found* found) {
    if constexpr (requires { finder.find_all(begin, end, found); })
        finder.find_all(begin, end, found);
    else
        for (std::uint32_t i = begin; i < end; ++i) new (found + (i - begin)) Found(finder.find(i));
}

/// What select() lists for an item that is wanted: the item, or `listed(item)` if the test has that
/// function.
template <class F>
PIERCE_HD std::uint32_t listed(const F& wanted, std::uint32_t i) {
    if constexpr (requires { wanted.listed(i); })
        return wanted.listed(i);
    else
        return i;
}

/// Emits what `Finder` finds for the items that are wanted.
template <class Wanted, class Finder>
struct FindWanted {
    Wanted wanted;
    Finder finder;

    FindWanted(const Wanted& its_wanted, const Finder& its_finder)
        : wanted(its_wanted), finder(its_finder) {}
    PIERCE_HD auto find(std::uint32_t i) const {
        return wanted(i) ? finder.find(i) : decltype(finder.find(i)){};
    }
    template <class Found>
    PIERCE_HD static std::uint32_t count(const Found& found) {
        return Finder::count(found);
    }
    template <class Found, class... T>
    PIERCE_HD void write(std::uint32_t i, const Found& found, std::uint32_t place,
                         T*... lists) const {
        if (Finder::count(found) > 0) finder.write(i, found, place, lists...);
    }
};

/// Emits what `Finder` finds for an item after stage `First` has run for that item.
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
    PIERCE_HD void write(std::uint32_t i, const Found& found, std::uint32_t place,
                         T*... lists) const {
        finder.write(i, found, place, lists...);
    }
};

}  // namespace pierce
