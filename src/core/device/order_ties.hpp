#pragma once

#include <cstdint>

#include "core/device/heap_sort.hpp"
#include "core/device/view.hpp"
#include "pierce/constants.hpp"

namespace pierce {

/// Per place in a sorted list: if it is the first one with its key, brings all with that key into
/// order. `before(a, b)` compares two of the list's items and is never false both ways. Most keys
/// are alone or few; where one feature meets a much larger one, there are thousands.
template <class Before>
PIERCE_HD void order_ties(View<const std::uint64_t> keys, View<std::uint32_t> order,
                          std::uint32_t first, const Before& before) {
    if (first > 0 && keys[first - 1] == keys[first]) return;
    std::uint32_t end = first + 1;
    for (; end < keys.size && keys[end] == keys[first]; ++end) {
        if (end - first >= constants::few_ties) continue;
        const std::uint32_t item = order[end];
        std::uint32_t place = end;
        for (; place > first && before(item, order[place - 1]); --place)
            order[place] = order[place - 1];
        order[place] = item;
    }
    if (end - first > constants::few_ties) heap_sort(order.data + first, end - first, before);
}

}  // namespace pierce
