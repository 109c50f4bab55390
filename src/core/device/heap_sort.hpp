#pragma once

#include <cstdint>

#include "pierce/host_device.hpp"

namespace pierce {

namespace detail {
/// Lets the item at `root` sink until no item below it belongs after it; the heap's last item is
/// the one before `count`.
template <class T, class Before>
PIERCE_HD void sink(T* items, std::uint32_t root, std::uint32_t count, const Before& before) {
    const T item = items[root];
    for (std::uint32_t below = 2 * root + 1; below < count; below = 2 * root + 1) {
        if (below + 1 < count && before(items[below], items[below + 1])) ++below;
        if (!before(item, items[below])) break;
        items[root] = items[below];
        root = below;
    }
    items[root] = item;
}
}  // namespace detail

/// Sorts items in place, on host and device, in n log n steps whatever their order is. Items of
/// which neither comes before the other end in any order.
template <class T, class Before>
PIERCE_HD void heap_sort(T* items, std::uint32_t count, const Before& before) {
    for (std::uint32_t root = count / 2; root-- > 0;) detail::sink(items, root, count, before);
    for (std::uint32_t last = count; last-- > 1;) {
        const T largest = items[0];
        items[0] = items[last];
        items[last] = largest;
        detail::sink(items, 0, last, before);
    }
}

}  // namespace pierce
