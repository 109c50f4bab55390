#include "pierce/contact_changes.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace pierce {
namespace {

auto key_of(const Contact& c) { return std::tuple(c.a, c.b, c.feature()); }

/// The places of a list, sorted by what their contacts are.
std::vector<std::uint32_t> sorted(std::span<const Contact> contacts) {
    std::vector<std::uint32_t> places(contacts.size());
    std::iota(places.begin(), places.end(), 0u);
    std::ranges::sort(places, {}, [&](std::uint32_t i) { return key_of(contacts[i]); });
    return places;
}

}  // namespace

ContactChanges contact_changes(std::span<const Contact> earlier, std::span<const Contact> later) {
    ContactChanges changes;
    const std::vector<std::uint32_t> before = sorted(earlier), now = sorted(later);
    auto at = before.begin();
    for (std::uint32_t i : now) {
        const auto key = key_of(later[i]);
        for (; at != before.end() && key_of(earlier[*at]) < key; ++at) changes.ended.push_back(*at);
        const bool was_there = at != before.end() && key_of(earlier[*at]) == key;
        (was_there ? changes.stayed : changes.began).push_back(i);
        if (was_there) ++at;
    }
    changes.ended.insert(changes.ended.end(), at, before.end());
    for (auto* places : {&changes.began, &changes.stayed, &changes.ended})
        std::ranges::sort(*places);
    return changes;
}

}  // namespace pierce
