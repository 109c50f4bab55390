#pragma once

#include "core/body/body_view.hpp"
#include "core/device/atomics.hpp"
#include "core/device/view.hpp"
#include "core/trace/bvh/forest.hpp"
#include "core/trace/bvh/morton.hpp"
#include "pierce/min_max.hpp"

/// The linear BVH (Lauterbach et al. 2009): leaves are sorted along a Morton curve and split where
/// their codes differ first. The tree is built bottom-up, hierarchy and boxes at once (Apetrei,
/// CGVC 2014). One sort and one launch build all trees of a forest: the tree is the upper part of
/// the key.
namespace pierce::bvh {

/// Per place: writes a value.
struct Fill {
    View<std::uint32_t> values;
    std::uint32_t value = 0;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const { values[i] = value; }
};

/// How many of a sort key's 64 bits tell trees apart; at least one.
PIERCE_HD inline std::uint32_t tree_bits(std::uint32_t tree_count) {
    std::uint32_t bits = 1;
    while ((std::uint64_t{1} << bits) < tree_count) ++bits;
    return bits;
}

/// The cube that a box fits in. Cells in the shape of a slim box would make slim nodes.
PIERCE_HD inline Box cube_around(const Box& box) {
    const Vec3d sides = box.upper - box.lower;
    const double side = max_of(sides.x, max_of(sides.y, sides.z));
    return {box.lower, box.lower + Vec3d{side, side, side}};
}

/// By how many bits the code of a tree's leaves is shorter than 63: the grid of a small tree's
/// cells is coarser (hlbvh.hpp), about as many cells as leaves in a volume, so that a cell of a
/// surface has several leaves.
PIERCE_HD inline std::uint32_t coarseness(std::uint32_t leaves) {
    std::uint32_t bits = 1;
    while (bits < constants::cell_bits && (std::uint32_t{1} << bits) < leaves) ++bits;
    return constants::cell_bits - bits;
}

/// Per leaf from `first` on: its sort key and its place in the meshes' order.
struct LeafKeys {
    View<const BodyView> bodies;
    Forest forest;
    std::uint32_t bits = 1;   ///< tree_bits()
    std::uint32_t first = 0;  ///< of the forest's leaves
    View<std::uint64_t> keys;
    View<std::uint32_t> leaves;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t leaf = first + i, t = forest.tree_of_leaf[leaf];
        const BodyView& body = bodies[forest.trees[t].body];
        const BoxF box = leaf_box(body, leaf - forest.trees[t].first);
        const Vec3d center = 0.5 * (to_double(box.lower) + to_double(box.upper));
        keys[i] = std::uint64_t{t} << (64 - bits) |
                  morton_code(center, cube_around(positions_box(body))) >>
                      (bits - 1 + coarseness(forest.trees[t].count));
        leaves[i] = leaf;
    }
};

/// A tree, or a part of one that does not hang on a node yet.
struct Subtree {
    Item item;
    BoxF box;
    std::uint32_t first = 0, last = 0;  ///< its leaves' places in sorted order

    PIERCE_HD std::uint32_t leaves() const { return last - first + 1; }
};

/// The LBVH of every group of leaves; the leaves of a group agree in the upper bits of their keys.
struct Lbvh {
    View<const BodyView> bodies;
    Forest forest;
    View<const std::uint64_t> keys;    ///< sorted
    View<const std::uint32_t> leaves;  ///< in that order
    std::uint32_t first = 0;           ///< node of the forest that splits after place 0
    std::uint32_t group_bits = 1;

    /// Climbs from the leaf at place i as long as it is the second to reach each node, and writes
    /// child and box there. `below` becomes the subtree below the last node reached; true if that
    /// is the whole group.
    PIERCE_HD bool climb(std::uint32_t i, Subtree& below) const {
        const Tree& tree = tree_at(i);
        const std::uint32_t leaf = leaves[i] - tree.first;
        below = {.item = Item::leaf(leaf),
                 .box = leaf_box(bodies[tree.body], leaf),
                 .first = i,
                 .last = i};
        while (true) {
            const bool at_begin = begins(below.first), at_end = begins(below.last + 1);
            if (at_begin && at_end) return true;
            // Node k splits between places k and k + 1. Of the nodes at its two ends, a child
            // belongs to the one across which the keys differ less.
            const bool is_left = at_begin || (!at_end && splits_later(below.first - 1, below.last));
            const std::uint32_t at = is_left ? below.last : below.first - 1;
            const std::uint32_t side = is_left ? 0 : 1;
            const std::uint32_t node = first + at;
            set_child(forest, tree, Place::at(node, side), below.item, below.box);
            const std::uint32_t other = atomic_exchange(forest.visits[node],
                                                        is_left ? below.first : below.last);
            if (other == no_node) return false;
            (is_left ? below.last : below.first) = other;
            below.item = Item::node(node);
            // The order of the boxes is the same whichever child comes second: it matters where
            // boxes hold NaN.
            const BoxF& beside = forest.nodes[node].box[1 - side];
            below.box = is_left ? join(below.box, beside) : join(beside, below.box);
        }
    }

    PIERCE_HD Tree& tree_at(std::uint32_t place) const {
        return forest.trees[forest.tree_of_leaf[leaves[place]]];
    }

    /// True if a group begins at this place, or if the list ends there.
    PIERCE_HD bool begins(std::uint32_t place) const {
        return place == 0 || place == keys.size ||
               (keys[place - 1] ^ keys[place]) >> (64 - group_bits) != 0;
    }

private:
    /// True if the keys at a and a + 1 differ in a higher bit than those at b and b + 1. Equal keys
    /// differ by their places.
    PIERCE_HD bool splits_later(std::uint32_t a, std::uint32_t b) const {
        const std::uint64_t at_a = keys[a] ^ keys[a + 1], at_b = keys[b] ^ keys[b + 1];
        if (at_a != at_b) return at_b < at_a;
        return (b ^ (b + 1)) < (a ^ (a + 1));
    }
};

/// Per place in sorted order: its share of building the trees. Each tree is one group.
struct BuildLbvh {
    Lbvh lbvh;

    PIERCE_HD void operator()(std::uint32_t i) const {
        Subtree whole;
        if (lbvh.climb(i, whole)) set_root(lbvh.forest, lbvh.tree_at(i), whole.item);
    }
};

}  // namespace pierce::bvh
