#pragma once

#include <bit>

#include "pierce/core/body.hpp"
#include "pierce/core/oriented_box.hpp"

/// Stage 2, pairs: bodies whose boxes overlap, sorted by (a, b). Sort and sweep along x, then the oriented boxes.
namespace pierce::stages {

/// A key that orders like the number it is made from.
PIERCE_HD inline std::uint32_t ordered_bits(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/// Per body: the key to sweep by. Bodies left out of the step go last.
struct SweepKey {
    View<const BodyView> bodies;
    View<std::uint64_t> keys;
    View<std::uint32_t> order;

    PIERCE_HD void operator()(std::uint32_t i) const {
        order[i] = i;
        keys[i] = bodies[i].active ? ordered_bits(round_down(bodies[i].world_box.lower.x)) : ~std::uint64_t{0};
    }
};

/// The test that makes two bodies a pair.
PIERCE_HD inline bool is_pair(const BodyView& a, const BodyView& b) {
    if (a.motion == Motion::fixed && b.motion == Motion::fixed) return false;
    const double margin = max_of(a.touch, b.touch);
    return overlap(a.world_box.inflated(margin), b.world_box) &&
           oriented_boxes_overlap(a.fit, a.fit_box, b.fit, b.fit_box, margin);
}

/// Per place in the sweep order: visits the partners that come later, counting them or writing their keys.
struct SweepPairs {
    View<const BodyView> bodies;
    View<const std::uint32_t> order;
    View<std::uint32_t> counts;  ///< written if `keys` is empty
    View<const std::uint32_t> offsets;
    View<std::uint64_t> keys;  ///< a << 32 | b
    View<std::uint32_t> values;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t body = order[i];
        const BodyView& first = bodies[body];
        std::uint32_t found = 0;
        if (first.active) {
            const double end = first.world_box.upper.x + first.touch;
            for (std::uint32_t k = i + 1; k < order.size; ++k) {
                const BodyView& second = bodies[order[k]];
                if (!second.active || round_down(second.world_box.lower.x) - second.touch > end) break;
                if (!is_pair(first, second)) continue;
                if (keys.data != nullptr) {
                    const std::uint64_t a = min_of(body, order[k]), b = max_of(body, order[k]);
                    keys[offsets[i] + found] = a << 32 | b;
                    values[offsets[i] + found] = 0;
                }
                ++found;
            }
        }
        if (keys.data == nullptr) counts[i] = found;
    }
};

/// Per pair: unpacks the sorted keys.
struct UnpackPair {
    View<const std::uint64_t> keys;
    View<Pair> pairs;

    PIERCE_HD void operator()(std::uint32_t i) const {
        pairs[i] = {static_cast<std::uint32_t>(keys[i] >> 32), static_cast<std::uint32_t>(keys[i])};
    }
};

}  // namespace pierce::stages
