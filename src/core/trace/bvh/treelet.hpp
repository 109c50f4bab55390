#pragma once

#include <utility>

#include "core/device/atomics.hpp"
#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/trace/bvh/lbvh.hpp"
#include "pierce/min_max.hpp"

/// Treelet restructuring (Karras and Aila, HPG 2013): the top of every subtree, cut off where it
/// has seven parts, is put together anew in the best of all ways. The parts stay the same, so they
/// cost the same in all ways, and the best way is the one whose nodes have the least area.
namespace pierce::bvh {

/// The top of a subtree: `inner` nodes and the parts below them.
class Treelet {
public:
    /// Opens parts, the largest first, until there are `parts` of them. The subtree must have at
    /// least that many leaves.
    PIERCE_HD Treelet(const Forest& forest, std::uint32_t root) {
        const Node& top = forest.nodes[root];
        part_[0] = Item::node(root);
        box_[0] = join(top.box[0], top.box[1]);
        for (std::uint32_t n = 0; n < inner; ++n) {
            const std::uint32_t k = largest_node(n + 1);
            node_[n] = part_[k].index();
            area_ += box_[k].half_area();
            const Node& node = forest.nodes[node_[n]];
            part_[k] = node.child[0];
            box_[k] = node.box[0];
            part_[n + 1] = node.child[1];
            box_[n + 1] = node.box[1];
        }
    }

    /// Puts the nodes together anew if that makes them smaller.
    PIERCE_HD void improve(const Forest& forest) {
        // Sets that differ only in their first parts share the box of the other parts.
        constexpr std::uint32_t shared = parts / 2;
        constexpr Set firsts = (Set{1} << shared) - 1;
        for (Set others = 0; others <= all; others += firsts + 1) {
            const BoxF beyond = box_of(others, shared, parts);
            for (Set set = others; set <= (others | firsts); ++set)
                least_[set] = is_one(set) ? 0
                                          : join(box_of(set, 0, shared), beyond).half_area() +
                                                least_below(set);
        }
        if (least_[all] < area_) rebuild(forest);
    }

private:
    static constexpr std::uint32_t parts = constants::treelet_parts, inner = parts - 1;

    using Set = std::uint32_t;  ///< of parts, one bit each
    static constexpr Set all = (Set{1} << parts) - 1;
    PIERCE_HD static bool is_one(Set set) { return (set & (set - 1)) == 0; }  ///< also true of none

    /// Of the first n parts, the largest one that is a node.
    PIERCE_HD std::uint32_t largest_node(std::uint32_t n) const {
        std::uint32_t largest = n;
        for (std::uint32_t k = 0; k < n; ++k)
            if (!part_[k].is_leaf() &&
                (largest == n || box_[k].half_area() > box_[largest].half_area()))
                largest = k;
        return largest;
    }

    /// The box around those parts k of a set for which begin <= k < end.
    PIERCE_HD BoxF box_of(Set set, std::uint32_t begin = 0, std::uint32_t end = parts) const {
        BoxF box = BoxF::none();
        for (std::uint32_t k = begin; k < end; ++k)
            if (set >> k & 1) box.extend(box_[k]);
        return box;
    }

    /// Area below the best node over `set`: the least over all ways to halve `set`. The set's first
    /// part is always in the same half.
    PIERCE_HD float least_below(Set set) const {
        const Set rest = set & (set - 1);
        float least = INFINITY;
        for (Set half = rest; half != 0; half = (half - 1) & rest)
            least = min_of(least_[half] + least_[set ^ half], least);
        return least;
    }

    /// In the best way to halve `set`, the half without the set's first part.
    PIERCE_HD Set best_half(Set set) const {
        const Set rest = set & (set - 1);
        const float least = least_below(set);
        Set half = rest;
        while (least_[half] + least_[set ^ half] > least) half = (half - 1) & rest;
        return half;
    }

    PIERCE_HD void rebuild(const Forest& forest) const {
        const Tree& tree = forest.trees[forest.tree_of_leaf[node_[0]]];
        Set set[inner] = {all};
        std::uint32_t known = 1;
        for (std::uint32_t n = 0; n < inner; ++n) {
            const Set half = best_half(set[n]), halves[2] = {set[n] ^ half, half};
            for (std::uint32_t side = 0; side < 2; ++side) {
                Item child;
                if (is_one(halves[side])) {
                    std::uint32_t k = 0;
                    while (halves[side] >> k != 1) ++k;
                    child = part_[k];
                } else {
                    set[known] = halves[side];
                    child = Item::node(node_[known++]);
                }
                set_child(forest, tree, Place::at(node_[n], side), child, box_of(halves[side]));
            }
        }
    }

    Item part_[parts];
    BoxF box_[parts];            ///< of the parts
    std::uint32_t node_[inner];  ///< root first
    float area_ = 0;             ///< of the nodes
    float least_[all + 1];       ///< per set of parts: area of the best tree over the set, its root
                                 ///< included
};

/// Per place in `leaves`: climbs from that leaf, counting leaves in `forest.visits`, as long as it
/// is the second to reach each node, up to a node with enough leaves.
struct FindTreelets {
    Forest forest;
    View<const std::uint32_t> leaves;
    std::uint32_t smallest = 0;  ///< leaves that are enough
    View<std::uint32_t> found;   ///< the node, or no_node

    PIERCE_HD void operator()(std::uint32_t i) const {
        found[i] = no_node;
        std::uint32_t count = 1;
        for (Place place = forest.leaf_places[leaves[i]]; !place.is_root();
             place = forest.nodes[place.node()].parent) {
            const std::uint32_t others = atomic_add(forest.visits[place.node()], count);
            if (others == 0) return;
            count += others;
            if (count < smallest) continue;
            found[i] = place.node();
            return;
        }
    }
};

/// Per node whose subtree is finished: improves the treelet there, and goes on to the node above if
/// it is the last child of that node to get there.
struct ImproveTreelets {
    Forest forest;
    View<const std::uint32_t> nodes, places;  ///< item i is nodes[places[i]]
    bool climbs = false;  ///< goes on with the node above; otherwise leaves it to the next launch
    View<std::uint32_t> next;  ///< the node above, or no_node

    PIERCE_HD void operator()(std::uint32_t i) const {
        std::uint32_t node = nodes[places[i]];
        next[i] = no_node;
        while (true) {
            Treelet(forest, node).improve(forest);
            const Place place = forest.nodes[node].parent;
            if (place.is_root()) return;
            node = place.node();
            if (atomic_add(forest.visits[node], 1) == 0) return;
            if (climbs) continue;
            next[i] = node;
            return;
        }
    }
};

/// True for places that hold a node.
struct HoldsNode {
    View<const std::uint32_t> nodes;

    PIERCE_HD bool operator()(std::uint32_t i) const { return nodes[i] != no_node; }
};

/// Restructures all trees of a forest, from the leaves up. A launch improves every treelet whose
/// subtree is finished, so that neighbouring threads all have work; when few treelets are left, a
/// last launch climbs to the roots.
template <Executor E>
class TreeletRestructuring {
public:
    /// `leaves`: all leaves, neighbours close together. The values it leaves in `forest.visits` are
    /// of no use.
    void run(E& executor, const Forest& forest, View<const std::uint32_t> leaves) {
        for (Buffer* buffer : {&nodes_, &next_, &places_}) buffer->resize(leaves.size);
        for (std::uint32_t round = 0; round < constants::treelet_rounds; ++round) {
            executor.for_each(leaves.size, Fill{forest.visits, 0});
            executor.for_each(leaves.size,
                              FindTreelets{.forest = forest,
                                           .leaves = leaves,
                                           .smallest = constants::treelet_parts << round,
                                           .found = view_of(next_)});
            bool climbs = false;
            for (std::uint32_t n = keep(executor, leaves.size); n > 0;
                 n = climbs ? 0 : keep(executor, n)) {
                climbs = n <= constants::treelet_crowd;
                executor.for_each(n, ImproveTreelets{.forest = forest,
                                                     .nodes = view_of(std::as_const(nodes_)),
                                                     .places = view_of(std::as_const(places_)),
                                                     .climbs = climbs,
                                                     .next = view_of(next_)});
            }
        }
    }

private:
    using Buffer = typename E::template Buffer<std::uint32_t>;

    /// Makes the nodes among the first n of next_ the next ones; returns how many there are.
    std::uint32_t keep(E& executor, std::uint32_t n) {
        std::swap(nodes_, next_);
        return executor.number(executor.select(
            ListId::treelets, n, HoldsNode{view_of(std::as_const(nodes_))}, view_of(places_)));
    }

    Buffer nodes_, next_, places_;
};

}  // namespace pierce::bvh
