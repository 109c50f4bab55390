#pragma once

#include "core/trace/bvh/forest.hpp"

namespace pierce::bvh {

/// What a random ray that meets the tree's box costs, by the surface area heuristic (MacDonald and
/// Booth 1990): nodes visited and leaves tested, at constants::node_cost and leaf_cost. It runs on
/// the host. Zero for a tree without extent.
inline double sah_cost(const Forest& forest, const Tree& tree) {
    if (tree.root.is_leaf()) return constants::leaf_cost;
    const Node& root = forest.nodes[tree.root.index()];
    const double whole = join(root.box[0], root.box[1]).half_area();
    if (!(whole > 0)) return 0;
    double cost = constants::node_cost * whole;
    for (std::uint32_t n = tree.first; n < tree.first + tree.count - 1; ++n)
        for (int side = 0; side < 2; ++side) {
            const Node& node = forest.nodes[n];
            cost += (node.child[side].is_leaf() ? constants::leaf_cost : constants::node_cost) *
                    node.box[side].half_area();
        }
    return cost / whole;
}

}  // namespace pierce::bvh
