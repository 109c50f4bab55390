#pragma once

#include <cstdint>

#include "pierce/host_device.hpp"

/// What a stage may say of itself to executors, and what they make of it.
namespace pierce {

/// True for a stage that says its items take a few nanoseconds each: `static constexpr bool
/// is_cheap = true`. Executors then hand out many at once.
template <class Stage>
constexpr bool is_cheap() {
    if constexpr (requires { Stage::is_cheap; })
        return Stage::is_cheap;
    else
        return false;
}

/// True for a stage whose list is in the order of its items in any case (`static constexpr bool
/// in_order = true`).
template <class F>
constexpr bool in_order() {
    if constexpr (requires { F::in_order; })
        return F::in_order;
    else
        return false;
}

/// What select() lists of an item that is wanted: the item, unless the test has something else to
/// say, `listed(item)`.
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
    PIERCE_HD void write(std::uint32_t i, const Found& found, std::uint32_t place,
                         T*... lists) const {
        finder.write(i, found, place, lists...);
    }
};

}  // namespace pierce
