#pragma once

#include <cstdint>
#include <utility>

#include "pierce/core/bvh/lbvh.hpp"
#include "pierce/core/bvh/treelet.hpp"
#include "pierce/core/executor.hpp"

namespace pierce {

/// How trees are built: from the fastest to build to the fastest to trace.
enum class TreeBuilder : std::uint8_t {
    lbvh,   ///< along a Morton curve
    trbvh,  ///< that, restructured
};

}  // namespace pierce

namespace pierce::bvh {

/// Builds all trees of a forest, hierarchy and boxes, in one set of launches.
template <Executor E>
class ForestBuilder {
public:
    explicit ForestBuilder(TreeBuilder how) : how_(how) {}

    /// Fills nodes, leaf_places and the trees' roots. `forest.visits` is scratch; all zero afterwards.
    void build(E& executor, View<const BodyView> bodies, const Forest& forest) {
        const std::uint32_t leaves = forest.tree_of_leaf.size;
        keys_.resize(leaves);
        leaves_.resize(leaves);
        executor.for_each("clear_visits", leaves, Fill{forest.visits, no_node});
        executor.for_each("leaf_keys", leaves,
                          LeafKeys{bodies, forest, tree_bits(forest.trees.size), view_of(keys_), view_of(leaves_)});
        executor.sort("leaf_sort", leaves, view_of(keys_), view_of(leaves_));
        executor.for_each("build_lbvh", leaves, BuildLbvh{bodies, forest, view_of(keys_), view_of(leaves_)});
        if (how_ == TreeBuilder::trbvh) restructuring_.run(executor, forest, view_of(std::as_const(leaves_)));
        executor.for_each("clear_visits", leaves, Fill{forest.visits, 0});
    }

private:
    template <class T>
    using Buffer = typename E::template Buffer<T>;

    TreeBuilder how_;
    Buffer<std::uint64_t> keys_;
    Buffer<std::uint32_t> leaves_;
    TreeletRestructuring<E> restructuring_;
};

}  // namespace pierce::bvh
