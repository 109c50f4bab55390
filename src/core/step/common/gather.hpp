#pragma once

#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/device/atomics.hpp"
#include "core/device/view.hpp"
#include "core/trace/ray.hpp"
#include "pierce/body.hpp"

/// Moving listed items together and back, and what all kinds of rays share.
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

/// Per ray: marks its target, if the ray is to be traced.
struct MarkWanted {
    View<const Ray> rays;
    View<std::uint32_t> wanted;  ///< per body

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (rays[i].t_max >= 0) atomic_mark(wanted[rays[i].target]);
    }
};

/// Tells items that are marked.
struct IsMarked {
    View<const std::uint32_t> marks;

    PIERCE_HD bool operator()(std::uint32_t i) const { return marks[i] != 0; }
};

/// Per item: zero.
struct Clear {
    View<std::uint32_t> items;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const { items[i] = 0; }
};

/// Per body: marks those that rays may be aimed at.
struct MarkTargets {
    View<const BodyView> bodies;
    View<std::uint32_t> wanted;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        wanted[i] = !bodies[i].collision.sheet || bodies[i].sends_velocity_rays();
    }
};

}  // namespace pierce::stages
