#include "scenes/measure/contact_error.hpp"

#include <algorithm>

namespace pierce::scenes {

void ContactComparison::add(std::span<const Contact> expected, std::span<const Contact> found) {
    const auto key = [](const Contact& c) { return Key{c.a, c.b, c.feature()}; };
    std::map<Key, const Contact*> there;
    for (const Contact& c : found) there[key(c)] = &c;

    std::map<Key, bool> present;
    for (const Contact& c : expected) {
        const Key k = key(c);
        present[k] = true;
        const bool begins = !present_.contains(k);
        const auto it = there.find(k);
        ++error_.expected;
        error_.depth += c.penetration_depth();
        error_.first += begins;
        if (it != there.end()) {
            error_.wrong += it->second->triangle != c.triangle;
            there.erase(it);
            waiting_.erase(k);
            continue;
        }
        ++error_.missed;
        error_.missed_depth += c.penetration_depth();
        if (begins) {
            ++error_.first_missed;
            waiting_[k] = 0;
        }
        if (const auto waits = waiting_.find(k); waits != waiting_.end()) {
            ++error_.late_steps;
            error_.latest = std::max(error_.latest, ++waits->second);
        }
    }
    error_.added += there.size();
    present_ = std::move(present);
    std::erase_if(waiting_, [&](const auto& entry) { return !present_.contains(entry.first); });
}

}  // namespace pierce::scenes
