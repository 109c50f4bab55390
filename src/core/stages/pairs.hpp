#pragma once

#include <bit>

#include "pierce/core/body.hpp"
#include "pierce/core/ids.hpp"
#include "pierce/core/oriented_box.hpp"

/// Stage 2, pairs: bodies whose boxes overlap, and bodies that are looked for in themselves, sorted by (a, b). Sort and
/// sweep along x, then the oriented boxes.
namespace pierce::stages {

/// A key that orders like the number it is made from.
PIERCE_HD inline std::uint32_t ordered_bits(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/// Bits of a sweep key.
inline constexpr int sweep_key_bits = 32;

/// What the sweep looks at of a body: its box in the world, grown by touch tolerance and reach and rounded outwards. A body
/// left out of the step has an empty one, and comes last.
struct alignas(16) SweepItem {
    Vec3f lower, upper;
    std::uint32_t body = 0;
    bool moves = false;
    bool meets_itself = false;
    std::uint8_t padding[2] = {};

    PIERCE_HD SweepItem() = default;
    PIERCE_HD SweepItem(const BodyView& b, std::uint32_t index)
        : body(index), moves(b.motion != Motion::fixed), meets_itself(b.active && b.collision.self != SelfCollision::off) {
        const Box box = b.active ? b.world_box.inflated(b.touch + b.outreach()) : Box{};
        lower = {round_down(box.lower.x), round_down(box.lower.y), round_down(box.lower.z)};
        upper = {round_up(box.upper.x), round_up(box.upper.y), round_up(box.upper.z)};
    }
};

/// Per body: the key to sweep by.
struct SweepKey {
    View<const BodyView> bodies;
    View<std::uint64_t> keys;
    View<std::uint32_t> order;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        order[i] = i;
        keys[i] = bodies[i].active ? ordered_bits(SweepItem(bodies[i], i).lower.x) : ~std::uint64_t{0};
    }
};

/// Per place in the sweep order: what the sweep needs, side by side.
struct GatherSweep {
    View<const BodyView> bodies;
    View<const std::uint32_t> order;
    View<SweepItem> items;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const { items[i] = SweepItem(bodies[order[i]], order[i]); }
};

/// Per place in the sweep order, `walks` items: visit the partners that come later, taking turns, counting them or writing
/// their keys.
struct SweepPairs {
    View<const SweepItem> items;
    std::uint32_t walks = 1;
    View<std::uint32_t> counts;  ///< written if `keys` is empty
    View<const std::uint32_t> offsets;
    View<std::uint64_t> keys;  ///< a << 32 | b

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t place = i / walks;
        const SweepItem& first = items[place];
        std::uint32_t found = 0;
        if (first.meets_itself && i % walks == 0) {
            if (keys.data != nullptr) keys[offsets[i]] = std::uint64_t{first.body} << 32 | first.body;
            ++found;
        }
        for (std::uint32_t k = place + 1 + i % walks; k < items.size; k += walks) {
            const SweepItem& second = items[k];
            if (!(second.lower.x <= first.upper.x)) break;
            // Not a branch each: which of them is apart cannot be foreseen.
            const bool apart = (second.upper.y < first.lower.y) | (second.lower.y > first.upper.y) |
                               (second.upper.z < first.lower.z) | (second.lower.z > first.upper.z);
            if (apart | !(first.moves | second.moves)) continue;
            if (keys.data != nullptr) {
                const std::uint64_t a = min_of(first.body, second.body), b = max_of(first.body, second.body);
                keys[offsets[i] + found] = a << 32 | b;
            }
            ++found;
        }
        if (keys.data == nullptr) counts[i] = found;
    }
};

/// Per pair of overlapping world boxes: 1 if their oriented boxes, too, come as close as the touch tolerance, else 0.
struct TestPair {
    View<const BodyView> bodies;
    View<const std::uint64_t> keys;
    View<std::uint32_t> keep;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const BodyView& a = bodies[static_cast<std::uint32_t>(keys[i] >> 32)];
        const BodyView& b = bodies[static_cast<std::uint32_t>(keys[i])];
        keep[i] = oriented_boxes_overlap(a.fit, a.fit_box, b.fit, b.fit_box,
                                         max_of(a.touch, b.touch) + a.outreach() + b.outreach());
    }
};

/// Per pair of overlapping world boxes: moves the kept ones together.
struct KeepPair {
    View<const std::uint64_t> keys;
    View<const std::uint32_t> keep, offsets;
    View<std::uint64_t> kept;
    View<std::uint32_t> values;  ///< nothing; the sort wants some

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (!keep[i]) return;
        kept[offsets[i]] = keys[i];
        values[offsets[i]] = 0;
    }
};

/// What must be the same for a pair to be last step's pair again.
struct PairIdentity {
    BodyId a, b;
    std::uint64_t mesh_a = 0, mesh_b = 0;

    PIERCE_HD bool is(const PairIdentity& other) const {
        return a.index == other.a.index && a.generation == other.a.generation && b.index == other.b.index &&
               b.generation == other.b.generation && mesh_a == other.mesh_a && mesh_b == other.mesh_b;
    }
};

inline constexpr std::uint32_t no_pair = 0xffffffffu;

/// Per sorted key: the pair, who it is, and which of last step's pairs it was, if any.
struct LinkPair {
    View<const BodyView> bodies;
    View<const BodyId> ids;
    View<const std::uint64_t> keys, last_keys;
    View<const PairIdentity> last;
    View<Pair> pairs;
    View<PairIdentity> identities;
    View<std::uint32_t> links;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Pair pair{static_cast<std::uint32_t>(keys[i] >> 32), static_cast<std::uint32_t>(keys[i])};
        const PairIdentity identity{ids[pair.a], ids[pair.b], bodies[pair.a].mesh_key, bodies[pair.b].mesh_key};
        std::uint32_t low = 0, high = last_keys.size;
        while (low < high) {
            const std::uint32_t middle = low + (high - low) / 2;
            (last_keys[middle] < keys[i] ? low : high) = last_keys[middle] < keys[i] ? middle + 1 : middle;
        }
        pairs[i] = pair;
        identities[i] = identity;
        links[i] = low < last_keys.size && last_keys[low] == keys[i] && last[low].is(identity) ? low : no_pair;
    }
};

}  // namespace pierce::stages
