#pragma once

#include <cstdint>
#include <utility>

#include "core/device/bits.hpp"
#include "core/device/lanes.hpp"
#include "core/device/loops.hpp"
#include "core/device/quick_math.hpp"
#include "core/trace/bvh/forest.hpp"
#include "core/trace/bvh/part_sets.hpp"

namespace pierce::bvh {

/// The top of a subtree: `inner` nodes and the parts below them. It can be put together anew in the
/// best of all ways: the parts stay the same, so they cost the same in all ways, and the best way
/// is the one whose nodes have the least area (Karras and Aila, HPG 2013). `Who` works on it, Lanes
/// or one thread Alone.
template <class Who>
class Treelet {
    static constexpr std::uint32_t parts = treelet_parts, inner = parts - 1;
    static constexpr PartSet all = all_parts;

public:
    /// Per set of parts: area of the best tree over the set, its root included.
    using Areas = SharedNumbers<Who, all + 1>;

    /// Opens parts, the largest first, until there are `parts` of them. The subtree must have at
    /// least that many leaves.
    PIERCE_HD Treelet(const Forest& forest, std::uint32_t root, Areas& least) : least_(least) {
        float size[parts];
        const auto put = [&](std::uint32_t k, Item part, const BoxF& box) {
            part_[k] = part;
            box_[k] = box;
            const float area = box.half_area();
            size[k] = part.is_leaf() ? -1 : area < INFINITY ? area : INFINITY;
        };
        put(0, Item::node(root), join(forest.nodes[root].box[0], forest.nodes[root].box[1]));
        PIERCE_UNROLLED_LOOP
        for (std::uint32_t n = 0; n < inner; ++n) {
            std::uint32_t largest = 0;
            float most = size[0];
            PIERCE_UNROLLED_LOOP
            for (std::uint32_t k = 1; k <= n; ++k) {
                if (!(size[k] > most)) continue;
                largest = k;
                most = size[k];
            }
            area_ += most;
            node_[n] = at(part_, largest).index();
            const Node& node = forest.nodes[node_[n]];
            PIERCE_UNROLLED_LOOP
            for (std::uint32_t k = 0; k <= n; ++k)
                if (k == largest) put(k, node.child[0], node.box[0]);
            put(n + 1, node.child[1], node.box[1]);
        }
    }

    /// Puts the nodes together anew if that makes them smaller. `sets` are those of the lane.
    PIERCE_HD void improve(const Forest& forest, const ShareOfSets<Who>& sets) {
        measure_sets();
        Who::settle();
        if constexpr (Who::count == 1)
            add_below_each(std::make_integer_sequence<PartSet, all>());
        else
            add_below_by_size(sets);
        float least = INFINITY;
        each_half(all, [&](PartSet half) {
            least = quick_min(least_[half] + least_[all ^ half], least);
        });
        if (least_[all] + Who::least(least) < area_) rebuild(forest);
    }

private:
    /// One of the items of an array that is kept in registers.
    template <class T, std::size_t n>
    PIERCE_HD static T at(const T (&items)[n], std::uint32_t which) {
        T item = items[0];
        PIERCE_UNROLLED_LOOP
        for (std::uint32_t k = 1; k < n; ++k)
            if (k == which) item = items[k];
        return item;
    }

    /// Notes the area of the box of every set of two parts or more, and zero for the others. Sets
    /// that differ only in their first parts share the box of the other parts.
    PIERCE_HD void measure_sets() {
        constexpr std::uint32_t shared = parts / 2, firsts = 1u << shared;
        Who::share(0, (all + 1) >> shared, [&](PartSet others) {
            BoxF box[firsts];
            box[0] = BoxF::none();
            PIERCE_UNROLLED_LOOP
            for (std::uint32_t k = shared; k < parts; ++k)
                if (others >> (k - shared) & 1) extend(box[0], box_[k]);
            PIERCE_UNROLLED_LOOP
            for (PartSet first = 0; first < firsts; ++first) {
                PIERCE_UNROLLED_LOOP
                for (std::uint32_t k = 0; k < shared; ++k)
                    if (first >> k == 1) {
                        box[first] = box[first ^ 1u << k];
                        extend(box[first], box_[k]);
                    }
                const PartSet set = others << shared | first;
                least_[set] = has_one_part(set) ? 0 : box[first].half_area();
            }
        });
    }

    PIERCE_HD static void extend(BoxF& box, const BoxF& by) {
        for (int axis = 0; axis < 3; ++axis) {
            box.lower[axis] = quick_min(by.lower[axis], box.lower[axis]);
            box.upper[axis] = quick_max(by.upper[axis], box.upper[axis]);
        }
    }

    PIERCE_HD BoxF box_of(PartSet set) const {
        BoxF box = BoxF::none();
        PIERCE_UNROLLED_LOOP
        for (std::uint32_t k = 0; k < parts; ++k)
            if (set >> k & 1) box.extend(box_[k]);
        return box;
    }

    /// Adds to the area of every set the area below the best node over it: the least over all ways
    /// to halve the set. Its first part is always in the same half. Sets of two parts have no node
    /// below. The halves of a set have smaller numbers. All is known when this is compiled, so that
    /// the loads do not wait for each other.
    template <PartSet... set>
    PIERCE_HD void add_below_each(std::integer_sequence<PartSet, set...> /*all but the largest*/) {
        (add_below<set>(), ...);
    }
    template <PartSet set>
    PIERCE_HD void add_below() {
        constexpr std::uint32_t size = size_of(set);
        if constexpr (size > 2)
            least_[set] += least_below<set>(
                std::make_integer_sequence<PartSet, (1u << (size - 1)) - 1>());
    }
    template <PartSet set, PartSet... n>
    PIERCE_HD float least_below(
        std::integer_sequence<PartSet, n...> /*0, 1 .. one less than halves*/) {
        float least = INFINITY;
        ((least = quick_min(least_[nth_half<set, n + 1>] + least_[set ^ nth_half<set, n + 1>],
                            least)),
         ...);
        return least;
    }
    template <PartSet set, PartSet n>
    static constexpr PartSet nth_half = subset(set&(set - 1), n);

    /// The same by lanes, in order of size: the halves of a set have fewer parts than the set.
    PIERCE_HD void add_below_by_size(const ShareOfSets<Who>& sets) {
        PIERCE_UNROLLED_LOOP
        for (std::uint32_t size = 3; size < parts; ++size) {
            sets.each_of(size, [&](PartSet set) {
                const PartSet rest = set & (set - 1);
                float least = INFINITY;
                PartSet half = 0;
                PIERCE_UNROLLED_LOOP
                for (std::uint32_t n = 1; n < 1u << (size - 1); ++n) {
                    half = (half - rest) & rest;
                    least = quick_min(least_[half] + least_[set ^ half], least);
                }
                least_[set] += least;
            });
            Who::settle();
        }
    }

    /// Shows every half of `set` that is without the set's first part to one of those who work.
    template <class See>
    PIERCE_HD void each_half(PartSet set, const See& see) const {
        const PartSet rest = set & (set - 1);
        if constexpr (Who::count == 1) {
            for (PartSet half = rest; half != 0; half = (half - 1) & rest) see(half);
        } else {
            Who::share(1, 1u << bit_count(rest), [&](std::uint32_t n) { see(subset(rest, n)); });
        }
    }

    /// In the best way to halve `set`, the half without the set's first part.
    PIERCE_HD PartSet best_half(PartSet set) const {
        PartSet best = set & (set - 1);
        float least = INFINITY;
        each_half(set, [&](PartSet half) {
            const float area = least_[half] + least_[set ^ half];
            if (!(area < least)) return;
            least = area;
            best = half;
        });
        const std::uint32_t have_it = Who::ask(least == Who::least(least));
        return Who::from(have_it == 0 ? 0 : lowest_bit(have_it), best);
    }

    /// Finds which parts each node is over, then writes the sides of the nodes.
    PIERCE_HD void rebuild(const Forest& forest) const {
        SetList over, half;  // per node: the parts it is over, and those on its side 1
        over.put(0, all);
        std::uint32_t known = 1;
        for (std::uint32_t n = 0; n < inner; ++n) {
            const PartSet one = best_half(over[n]), other = over[n] ^ one;
            half.put(n, one);
            if (!has_one_part(other)) over.put(known++, other);
            if (!has_one_part(one)) over.put(known++, one);
        }
        const Tree& tree = forest.trees[forest.tree_of_leaf[node_[0]]];
        Who::share(0, 2 * inner, [&](std::uint32_t k) {
            const std::uint32_t n = k / 2, side = k % 2;
            const PartSet set = side == 0 ? over[n] ^ half[n] : half[n];
            Item child;
            PIERCE_UNROLLED_LOOP
            for (std::uint32_t i = 0; i < parts; ++i)
                if (set == 1u << i) child = part_[i];
            PIERCE_UNROLLED_LOOP
            for (std::uint32_t i = 1; i < inner; ++i)
                if (set == over[i]) child = Item::node(node_[i]);
            set_child(forest, tree, Place::at(at(node_, n), side), child, box_of(set));
        });
    }

    Areas& least_;
    Item part_[parts];
    BoxF box_[parts];            ///< of the parts
    std::uint32_t node_[inner];  ///< root first
    float area_ = 0;             ///< of the nodes
};

}  // namespace pierce::bvh
