#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/device/view.hpp"

namespace pierce {

/// Appends what several lists hold, each of which is sorted by key_of(list, item), in the order of
/// the keys. All items of a key come from one list.
template <class Item, class KeyOf>
void append_merged(const std::vector<View<const Item>>& lists, const KeyOf& key_of,
                   std::vector<Item>& merged) {
    constexpr std::uint64_t none = ~std::uint64_t{0};
    std::vector<std::uint32_t> next(lists.size(), 0);
    const auto key = [&](std::size_t list) {
        return next[list] == lists[list].size ? none : key_of(list, lists[list][next[list]]);
    };
    for (;;) {
        std::size_t first = 0;
        for (std::size_t list = 1; list < lists.size(); ++list)
            if (key(list) < key(first)) first = list;
        const std::uint64_t its_key = key(first);
        if (its_key == none) return;
        for (; key(first) == its_key; ++next[first]) merged.push_back(lists[first][next[first]]);
    }
}

}  // namespace pierce
