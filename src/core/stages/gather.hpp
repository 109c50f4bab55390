#pragma once

#include <cstdint>

#include "pierce/core/view.hpp"

/// Moving listed items together and back.
namespace pierce::stages {

/// Per place of a list: copies the item it names.
template <class Item>
struct Gather {
    View<const Item> items;
    View<const std::uint32_t> places;
    View<Item> gathered;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const { gathered[i] = items[places[i]]; }
};

/// Per place of a list: puts an item back where it came from.
template <class Item>
struct Scatter {
    View<const Item> gathered;
    View<const std::uint32_t> places;
    View<Item> items;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const { items[places[i]] = gathered[i]; }
};

}  // namespace pierce::stages
