#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/partition/contact_order.hpp"
#include "pierce/contact.hpp"

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

/// What one part has found in a step; each list is sorted by pair.
struct PartLists {
    View<const Contact> by_rays, of_sheets;
    View<const Pair> pairs;

    PartLists(View<const Contact> contacts, View<const Pair> all_pairs, View<const BodyView> bodies)
        : pairs(all_pairs) {
        const Contact* const first_of_sheets = std::partition_point(
            contacts.begin(), contacts.end(),
            [&](const Contact& c) { return is_by_ray(c, bodies); });
        by_rays = {contacts.data, static_cast<std::uint32_t>(first_of_sheets - contacts.begin())};
        of_sheets = {first_of_sheets, contacts.size - by_rays.size};
    }
    PartLists(View<const Contact> rays, View<const Contact> sheets, View<const Pair> all_pairs)
        : by_rays(rays), of_sheets(sheets), pairs(all_pairs) {}
};

/// Appends what all parts have found in the order in which one backend finds it. key_of(part,
/// pair): by which lists are sorted.
template <class KeyOf>
void append_merged(const std::vector<PartLists>& parts, const KeyOf& key_of,
                   std::vector<Contact>& contacts, std::vector<Pair>& pairs) {
    std::vector<View<const Contact>> by_rays, of_sheets;
    std::vector<View<const Pair>> of_parts;
    for (const PartLists& part : parts) {
        by_rays.push_back(part.by_rays);
        of_sheets.push_back(part.of_sheets);
        of_parts.push_back(part.pairs);
    }
    const auto key_of_contact = [&](std::size_t part, const Contact& c) {
        return key_of(part, Pair{c.a.index, c.b.index});
    };
    append_merged(by_rays, key_of_contact, contacts);
    append_merged(of_sheets, key_of_contact, contacts);
    append_merged(of_parts, key_of, pairs);
}

}  // namespace pierce
