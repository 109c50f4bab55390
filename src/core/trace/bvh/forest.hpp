#pragma once

#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/device/whole.hpp"
#include "pierce/body.hpp"
#include "pierce/min_max.hpp"

namespace pierce::bvh {

inline constexpr std::uint32_t no_node = 0xffffffffu;
inline constexpr std::uint32_t no_tree = 0xffffffffu;

/// Something in a tree: a node, by its place in the forest, or a leaf of the tree's mesh.
struct Item {
    static constexpr std::uint32_t leaf_bit = 0x80000000u;
    std::uint32_t code = no_node;

    PIERCE_HD static Item node(std::uint32_t index) { return {index}; }
    PIERCE_HD static Item leaf(std::uint32_t index) { return {index | leaf_bit}; }
    PIERCE_HD bool is_leaf() const { return (code & leaf_bit) != 0; }
    PIERCE_HD std::uint32_t index() const { return code & ~leaf_bit; }
};

/// A float32 box; the box of float32 points is exact.
struct BoxF {
    Vec3f lower, upper;

    /// The box of no points.
    PIERCE_HD static BoxF none() {
        return {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    }

    PIERCE_HD void extend(const BoxF& b) {
        lower = {min_of(b.lower.x, lower.x), min_of(b.lower.y, lower.y),
                 min_of(b.lower.z, lower.z)};
        upper = {max_of(b.upper.x, upper.x), max_of(b.upper.y, upper.y),
                 max_of(b.upper.z, upper.z)};
    }
    /// Half the surface area.
    PIERCE_HD float half_area() const {
        const Vec3f d = upper - lower;
        return d.x * d.y + d.y * d.z + d.z * d.x;
    }
};

PIERCE_HD inline BoxF join(BoxF a, const BoxF& b) {
    a.extend(b);
    return a;
}

/// Where an item hangs: a node, and which of its two sides.
struct Place {
    std::uint32_t code = no_node;

    PIERCE_HD static Place at(std::uint32_t node, std::uint32_t side) { return {node << 1 | side}; }
    PIERCE_HD bool is_root() const { return code == no_node; }
    PIERCE_HD std::uint32_t node() const { return code >> 1; }
    PIERCE_HD std::uint32_t side() const { return code & 1; }
};

/// A node holds its children's boxes, so that a ray reads one node to choose between two. A node
/// takes 64 bytes: a cache line of a processor, half a one of a GPU.
struct alignas(16) Node {
    BoxF box[2];
    Item child[2];
    Place parent;
    std::uint32_t unused = 0;

    /// The child on one side, without indexing by a value known only at run time: a GPU would move
    /// the node to memory for such an index.
    PIERCE_HD Item side(std::uint32_t which) const { return which == 0 ? child[0] : child[1]; }
};
static_assert(sizeof(Node) == 64);

/// One tree of the forest: over the leaves of a deforming body, or of a mesh that all its rigid
/// bodies share.
struct Tree {
    std::uint32_t first = 0;  ///< its leaves and nodes are [first, first + count) of the forest's;
                              ///< it has one node less than leaves
    std::uint32_t count = 0;  ///< leaves
    std::uint32_t body = 0;   ///< the body whose surface it holds, or one of several such bodies
    bool moves = false;       ///< the body deforms
    Item root;
    std::uint64_t fitted = fits_nothing;  ///< version of the positions its boxes fit

    static constexpr std::uint64_t fits_nothing = 0;  ///< no positions have this version
};

/// All trees of a scene side by side, so that each step of building and refitting is one launch for
/// all of them.
struct Forest {
    View<Tree> trees;
    View<const std::uint32_t> tree_of_body;  ///< no_tree: none
    View<const std::uint32_t> tree_of_leaf;
    View<Node> nodes;
    View<Place> leaf_places;     ///< per leaf: in the mesh's order, tree after tree
    View<std::uint32_t> visits;  ///< per node: children, or leaves, that have climbed to it
};

/// Notes where an item of a tree hangs.
PIERCE_HD inline void set_place(const Forest& forest, const Tree& tree, Item item, Place place) {
    (item.is_leaf() ? forest.leaf_places[tree.first + item.index()]
                    : forest.nodes[item.index()].parent) = place;
}

/// Hangs an item on a side of a node.
PIERCE_HD inline void set_child(const Forest& forest, const Tree& tree, Place place, Item item,
                                const BoxF& box) {
    Node& node = forest.nodes[place.node()];
    node.child[place.side()] = item;
    node.box[place.side()] = box;
    set_place(forest, tree, item, place);
}

/// Makes an item the root of its tree.
PIERCE_HD inline void set_root(const Forest& forest, Tree& tree, Item item) {
    tree.root = item;
    set_place(forest, tree, item, {});
}

PIERCE_HD inline BoxF box_around(Vec3f a, Vec3f b, Vec3f c) {
    return {{min_of(a.x, min_of(b.x, c.x)), min_of(a.y, min_of(b.y, c.y)),
             min_of(a.z, min_of(b.z, c.z))},
            {max_of(a.x, max_of(b.x, c.x)), max_of(a.y, max_of(b.y, c.y)),
             max_of(a.z, max_of(b.z, c.z))}};
}

/// The box of a leaf at its body's current positions.
PIERCE_HD inline BoxF leaf_box(const BodyView& body, std::uint32_t leaf) {
    const Leaf at = read_whole(body.mesh.leaves[leaf]);
    const Vec3f last = body.positions[at.corner[3]];
    return join(box_around(body.positions[at.corner[0]], body.positions[at.corner[1]],
                           body.positions[at.corner[2]]),
                {last, last});
}

}  // namespace pierce::bvh
