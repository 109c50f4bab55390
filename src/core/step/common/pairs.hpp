#pragma once

#include "core/body/body_view.hpp"
#include "core/device/ordered_float.hpp"
#include "core/device/partition_point.hpp"
#include "core/device/view.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/geometry/oriented_box.hpp"
#include "core/step/common/records.hpp"
#include "pierce/body.hpp"
#include "pierce/constants.hpp"
#include "pierce/filter.hpp"
#include "pierce/ids.hpp"
#include "pierce/min_max.hpp"

/// pairs: bodies whose boxes overlap, and bodies that are tested against themselves, sorted by (a,
/// b). The stage sorts and sweeps along x, then tests the oriented boxes. If bodies are few, a
/// device tests all pairs at once.
namespace pierce::stages {

/// Bits of a sweep key.
inline constexpr int sweep_key_bits = 32;

/// What the sweep reads of a body: its box in the world, grown by touch tolerance and reach and
/// rounded outwards. A body left out of the step has an empty box, and comes last.
struct alignas(16) SweepItem {
    Vec3f lower, upper;
    std::uint32_t body = 0;
    bool moves = false;
    bool meets_itself = false;
    std::uint8_t padding[2] = {};

    PIERCE_HD SweepItem() = default;
    PIERCE_HD SweepItem(const BodyView& b, std::uint32_t index)
        : body(index),
          moves(b.motion != Motion::fixed),
          meets_itself(b.active && b.collision.self != SelfCollision::off) {
        const Box box = b.active ? b.world_box.inflated(b.touch + b.outreach_of_sheets()) : Box{};
        lower = {round_down(box.lower.x), round_down(box.lower.y), round_down(box.lower.z)};
        upper = {round_up(box.upper.x), round_up(box.upper.y), round_up(box.upper.z)};
    }

    /// True unless the boxes are apart along y or z, or neither body moves. The tests have no
    /// branch each, because a branch could not be predicted.
    PIERCE_HD bool may_meet(const SweepItem& other) const {
        const bool apart = (other.upper.y < lower.y) | (other.lower.y > upper.y) |
                           (other.upper.z < lower.z) | (other.lower.z > upper.z);
        return !(apart | !(moves | other.moves));
    }
};

/// How a pair is written as a number, so that pairs sorted by it are sorted by (a, b); with worlds,
/// by (world, a, b), and pairs of bodies that are in all worlds come last.
struct PairKeys {
    bool by_world = false;

    PIERCE_HD std::uint32_t body_bits() const { return by_world ? constants::body_bits : 32; }
    PIERCE_HD std::uint64_t key(View<const BodyView> bodies, std::uint32_t a,
                                std::uint32_t b) const {
        if (!by_world) return std::uint64_t{a} << 32 | b;
        const std::int32_t world = max_of(bodies[a].filter.world, bodies[b].filter.world);
        const std::uint64_t place = world == all_worlds ? constants::most_worlds
                                                        : static_cast<std::uint32_t>(world);
        return (place << constants::body_bits | a) << constants::body_bits | b;
    }
    PIERCE_HD Pair pair(std::uint64_t key) const {
        const std::uint64_t mask = (std::uint64_t{1} << body_bits()) - 1;
        return {static_cast<std::uint32_t>(key >> body_bits() & mask),
                static_cast<std::uint32_t>(key & mask)};
    }
};

/// Per body: the key to sweep by. Bodies of one world are side by side.
struct SweepKey {
    View<const BodyView> bodies;
    View<std::uint64_t> keys;
    View<std::uint32_t> order;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        order[i] = i;
        keys[i] = std::uint64_t{bodies[i].world_place} << 32 |
                  (bodies[i].active ? ordered_bits(SweepItem(bodies[i], i).lower.x) : ~0u);
    }
};

/// Per place in the sweep order: what the sweep needs, side by side.
struct GatherSweep {
    View<const BodyView> bodies;
    View<const std::uint32_t> order;
    View<SweepItem> items;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        items[i] = SweepItem(bodies[order[i]], order[i]);
    }
};

/// Per place in the sweep order, `walks` items: the items take turns to visit the partners that
/// come later in the same world, and those that are in all worlds.
struct SweepPairs {
    View<const SweepItem> items;
    View<const BodyView> bodies;
    View<const std::uint32_t> world_begins;  ///< as Scene has it
    PairKeys keys;
    std::uint32_t walks = 1;

    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        std::uint32_t found = 0;
        each(i, [&](std::uint32_t, std::uint32_t) { ++found; });
        return found;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t found) { return found; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t found, std::uint32_t place,
                         std::uint64_t* pairs) const {
        if (found == 0) return;
        each(i, [&](std::uint32_t body, std::uint32_t other) {
            pairs[place++] = keys.key(bodies, min_of(body, other), max_of(body, other));
        });
    }

private:
    template <class See>
    PIERCE_HD void each(std::uint32_t i, const See& see) const {
        const std::uint32_t place = i / walks;
        const SweepItem& first = items[place];
        if (first.meets_itself && i % walks == 0) see(first.body, first.body);
        std::uint32_t end = items.size, shared = items.size;
        if (world_begins.size > 0) {
            end = world_begins[bodies[first.body].world_place + 1];
            shared = max_of(world_begins[world_begins.size - 2], end);
        }
        for (std::uint32_t k = place + 1 + i % walks; k < end; k += walks) {
            const SweepItem& second = items[k];
            if (!(second.lower.x <= first.upper.x)) break;
            if (first.may_meet(second)) see(first.body, second.body);
        }
        for (std::uint32_t k = shared + i % walks; k < items.size; k += walks) {
            const SweepItem& second = items[k];
            if (!(second.lower.x <= first.upper.x)) break;
            if (first.lower.x <= second.upper.x && first.may_meet(second))
                see(first.body, second.body);
        }
    }
};

/// True if the oriented boxes of two bodies come as close as the bodies matter to each other.
PIERCE_HD inline bool fits_overlap(const BodyView& a, const BodyView& b) {
    const double more = a.collision.sheet || b.collision.sheet
                            ? a.outreach_of_sheets() + b.outreach_of_sheets()
                            : a.outreach() + b.outreach();
    return oriented_boxes_overlap(a.fit, a.fit_box, b.fit, b.fit_box,
                                  max_of(a.touch, b.touch) + more);
}

/// Which pairs the caller wants.
struct WantedPairs {
    View<const BodyView> bodies;
    View<const BodyId> ids;
    View<const Pair> excluded;           ///< sorted
    const PairFilter* filter = nullptr;  ///< none on a device
    std::uint32_t part = 0;              ///< pairs of other parts are looked at elsewhere

    PIERCE_HD bool is_here(Pair pair) const {
        const BodyView &a = bodies[pair.a], &b = bodies[pair.b];
        return part_of_pair(a.motion, a.part, b.motion, b.part) == part;
    }

    /// True unless a rule leaves the pair out.
    PIERCE_HD bool allows(Pair pair) const {
        if (pair.is_self()) return true;
        if (!bodies[pair.a].filter.allows(bodies[pair.b].filter)) return false;
        const std::uint32_t place = partition_point(
            excluded.size, [&](std::uint32_t i) { return excluded[i] < pair; });
        return place == excluded.size || !(excluded[place] == pair);
    }
    /// True unless the caller leaves the pair out when asked.
    PIERCE_HD bool wants([[maybe_unused]] Pair pair) const {
#ifndef __CUDA_ARCH__
        if (filter != nullptr && !pair.is_self()) return (*filter)(ids[pair.a], ids[pair.b]);
#endif
        return true;
    }
};

/// Per pair of overlapping world boxes: keeps the pair if it is wanted and the oriented boxes
/// overlap, too.
struct TestPair {
    WantedPairs wanted;
    PairKeys as_keys;
    View<const std::uint64_t> keys;

    PIERCE_HD bool find(std::uint32_t i) const {
        const Pair pair = as_keys.pair(keys[i]);
        return wanted.is_here(pair) && wanted.allows(pair) &&
               fits_overlap(wanted.bodies[pair.a], wanted.bodies[pair.b]) && wanted.wants(pair);
    }
    PIERCE_HD static std::uint32_t count(bool overlap) { return overlap; }
    PIERCE_HD void write(std::uint32_t i, bool overlap, std::uint32_t place,
                         std::uint64_t* kept) const {
        if (overlap) kept[place] = keys[i];
    }
};

/// The identity of a pair. What a body does with itself is no matter of its other pairs, and sheets
/// have no margin.
PIERCE_HD inline PairIdentity identity_of(View<const BodyView> bodies, View<const BodyId> ids,
                                          Pair pair) {
    const BodyView &a = bodies[pair.a], &b = bodies[pair.b];
    const auto self_of = [&](const BodyView& body) {
        return pair.is_self() ? body.collision.self : SelfCollision::off;
    };
    const bool has_sheet = a.collision.sheet || b.collision.sheet;
    return {.a = ids[pair.a],
            .b = ids[pair.b],
            .mesh_a = a.mesh_key,
            .mesh_b = b.mesh_key,
            .self_a = self_of(a),
            .self_b = self_of(b),
            .sheet_a = a.collision.sheet,
            .sheet_b = b.collision.sheet,
            .margin = has_sheet ? 0.0 : max_of(a.margin, b.margin)};
}

inline constexpr std::uint32_t no_pair = 0xffffffffu;

/// Which of last step's pairs a pair was.
struct LinkPair {
    View<const BodyView> bodies;
    View<const BodyId> ids;
    PairKeys as_keys;
    View<const std::uint64_t> last_keys;  ///< written as these; else none
    View<const PairIdentity> last;

    /// Writes the pair of a key, its identity, and which of last step's pairs it was, if any.
    PIERCE_HD void operator()(std::uint64_t key, Pair& pair, PairIdentity& identity,
                              std::uint32_t& link) const {
        pair = as_keys.pair(key);
        identity = identity_of(bodies, ids, pair);
        const std::uint32_t place = partition_point(
            last_keys.size, [&](std::uint32_t i) { return last_keys[i] < key; });
        const bool is_known = place < last_keys.size && last_keys[place] == key &&
                              last[place].is(identity);
        link = is_known ? place : no_pair;
    }
};

/// Per sorted key: the pair, and which of last step's pairs it was.
struct LinkSorted {
    LinkPair link;
    View<const std::uint64_t> keys;
    View<Pair> pairs;
    View<PairIdentity> identities;
    View<std::uint32_t> links;

    PIERCE_HD void operator()(std::uint32_t i) const {
        link(keys[i], pairs[i], identities[i], links[i]);
    }
};

/// Per two of `bodies.size` bodies (a * size + b): if they are a pair, their key and which of last
/// step's pairs it was. Not for bodies of several worlds.
struct FindPairs {
    LinkPair link;
    WantedPairs wanted;

    static constexpr bool in_order = true;

    PIERCE_HD bool find(std::uint32_t i) const {
        const View<const BodyView> bodies = link.bodies;
        const std::uint32_t a = i / bodies.size, b = i % bodies.size;
        if (b < a) return false;
        const SweepItem first(bodies[a], a), second(bodies[b], b);
        if (a == b) return first.meets_itself && wanted.is_here({a, b});
        if (!(second.lower.x <= first.upper.x) || !(first.lower.x <= second.upper.x)) return false;
        return first.may_meet(second) && wanted.is_here({a, b}) && wanted.allows({a, b}) &&
               fits_overlap(bodies[a], bodies[b]) && wanted.wants({a, b});
    }
    PIERCE_HD static std::uint32_t count(bool is_pair) { return is_pair; }
    PIERCE_HD void write(std::uint32_t i, bool is_pair, std::uint32_t place, std::uint64_t* keys,
                         Pair* pairs, PairIdentity* identities, std::uint32_t* links) const {
        if (!is_pair) return;
        keys[place] = link.as_keys.key(link.bodies, i / link.bodies.size, i % link.bodies.size);
        link(keys[place], pairs[place], identities[place], links[place]);
    }
    /// Fills an unused place: the next step searches the whole list.
    PIERCE_HD void pad(std::uint32_t place, std::uint64_t* keys, Pair*, PairIdentity*,
                       std::uint32_t*) const {
        keys[place] = ~std::uint64_t{0};
    }
};

}  // namespace pierce::stages
