#pragma once

#include "pierce/core/atomics.hpp"
#include "pierce/core/bvh/forest.hpp"
#include "pierce/core/bvh/morton.hpp"

/// The linear BVH (Lauterbach et al. 2009): leaves sorted along a Morton curve, split where their codes differ first. Built
/// bottom-up, hierarchy and boxes at once (Apetrei, CGVC 2014). All trees of a forest in one sort and one launch: the tree
/// is the upper part of the key.
namespace pierce::bvh {

/// Per place: writes a value.
struct Fill {
    View<std::uint32_t> values;
    std::uint32_t value = 0;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const { values[i] = value; }
};

/// Bits of a sort key that tell trees apart, of 64; at least one.
PIERCE_HD inline std::uint32_t tree_bits(std::uint32_t tree_count) {
    std::uint32_t bits = 1;
    while ((std::uint64_t{1} << bits) < tree_count) ++bits;
    return bits;
}

/// Per leaf: its sort key and its place in triangle order.
struct LeafKeys {
    View<const BodyView> bodies;
    Forest forest;
    std::uint32_t bits = 1;  ///< tree_bits()
    View<std::uint64_t> keys;
    View<std::uint32_t> leaves;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t t = forest.tree_of_leaf[i];
        const BodyView& body = bodies[forest.trees[t].body];
        const BoxF box = triangle_box(body.surface(), i - forest.trees[t].first);
        const Vec3d center = 0.5 * (to_double(box.lower) + to_double(box.upper));
        keys[i] = std::uint64_t{t} << (64 - bits) | morton_code(center, positions_box(body)) >> (bits - 1);
        leaves[i] = i;
    }
};

/// Per place in sorted order: climbs from that leaf as long as it comes second to every node, and writes child and box
/// there.
struct BuildLbvh {
    View<const BodyView> bodies;
    Forest forest;
    View<const std::uint64_t> keys;    ///< sorted
    View<const std::uint32_t> leaves;  ///< in that order

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t leaf = leaves[i], t = forest.tree_of_leaf[leaf];
        Tree& tree = forest.trees[t];
        const std::uint32_t begin = tree.first, last = tree.first + tree.count - 1;
        Item item = Item::leaf(leaf - begin);
        BoxF box = triangle_box(bodies[tree.body].surface(), leaf - begin);
        std::uint32_t left = i, right = i;
        while (left != begin || right != last) {
            // The node that splits between places k and k + 1 is node k; it is the child's that differs less from beyond.
            const bool is_left = left == begin || (right != last && splits_later(left - 1, right));
            const std::uint32_t at = is_left ? right : left - 1;
            const std::uint32_t side = is_left ? 0 : 1;
            set_child(forest, tree, Place::at(at, side), item, box);
            const std::uint32_t other = atomic_exchange(forest.visits[at], is_left ? left : right);
            if (other == no_node) return;
            (is_left ? right : left) = other;
            item = Item::node(at);
            box = join(box, forest.nodes[at].box[1 - side]);
        }
        tree.root = item;
        set_place(forest, tree, item, {});
    }

private:
    /// True if the keys at a and a + 1 differ in a higher bit than those at b and b + 1. Equal keys differ by their places.
    PIERCE_HD bool splits_later(std::uint32_t a, std::uint32_t b) const {
        const std::uint64_t at_a = keys[a] ^ keys[a + 1], at_b = keys[b] ^ keys[b + 1];
        if (at_a != at_b) return at_b < at_a;
        return (b ^ (b + 1)) < (a ^ (a + 1));
    }
};

}  // namespace pierce::bvh
