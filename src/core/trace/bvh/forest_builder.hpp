#pragma once

#include <cstdint>
#include <utility>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/trace/bvh/hlbvh.hpp"
#include "core/trace/bvh/lbvh.hpp"
#include "core/trace/bvh/ploc.hpp"
#include "core/trace/bvh/treelet_restructuring.hpp"
#include "pierce/tree_builder.hpp"

namespace pierce::bvh {

/// Builds all trees of a forest, hierarchy and boxes, in one set of launches.
template <Executor E>
class ForestBuilder {
public:
    explicit ForestBuilder(TreeBuilder how) : how_(how) {}

    /// Fills nodes, leaf_places and the trees' roots. `forest.visits` is scratch; all zero
    /// afterwards.
    void build(E& executor, View<const BodyView> bodies, const Forest& forest) {
        const std::uint32_t leaves = forest.tree_of_leaf.size;
        const std::uint32_t bits = tree_bits(forest.trees.size);
        keys_.resize(leaves);
        leaves_.resize(leaves);
        sorted_keys_.resize(leaves);
        sorted_leaves_.resize(leaves);
        executor.for_each(leaves, Fill{forest.visits, no_node});
        executor.for_each(leaves, LeafKeys{.bodies = bodies,
                                           .forest = forest,
                                           .bits = bits,
                                           .keys = view_of(keys_),
                                           .leaves = view_of(leaves_)});
        executor.sort(leaves, 64, view_of(keys_), view_of(leaves_), view_of(sorted_keys_),
                      view_of(sorted_leaves_));
        const auto sorted = view_of(std::as_const(sorted_leaves_));
        const Lbvh lbvh{.bodies = bodies,
                        .forest = forest,
                        .keys = view_of(std::as_const(sorted_keys_)),
                        .leaves = sorted,
                        .group_bits = bits};
        switch (how_) {
            case TreeBuilder::hlbvh:
                hlbvh_.build(executor, forest, lbvh);
                break;
            case TreeBuilder::ploc:
                ploc_.build(executor, bodies, forest, sorted);
                break;
            case TreeBuilder::lbvh:
            case TreeBuilder::trbvh:
                executor.for_each(leaves, BuildLbvh{lbvh});
        }
        if (how_ == TreeBuilder::trbvh) restructuring_.run(executor, forest, sorted);
        executor.for_each(leaves, Fill{forest.visits, 0});
    }

    /// Builds the LBVH of one tree, whose leaves are [first, first + count) of the forest's, and
    /// waits for nothing. Its `forest.visits` are all zero afterwards.
    void build_one(E& executor, View<const BodyView> bodies, const Forest& forest,
                   std::uint32_t first, std::uint32_t count) {
        const std::uint32_t bits = tree_bits(forest.trees.size);
        keys_.resize(count);
        leaves_.resize(count);
        sorted_keys_.resize(count);
        sorted_leaves_.resize(count);
        const View<std::uint32_t> visits{forest.visits.data + first, count};
        executor.for_each(count, Fill{visits, no_node});
        executor.for_each(count, LeafKeys{.bodies = bodies,
                                          .forest = forest,
                                          .bits = bits,
                                          .first = first,
                                          .keys = view_of(keys_),
                                          .leaves = view_of(leaves_)});
        executor.sort(count, 64, view_of(keys_), view_of(leaves_), view_of(sorted_keys_),
                      view_of(sorted_leaves_));
        executor.for_each(count, BuildLbvh{{.bodies = bodies,
                                            .forest = forest,
                                            .keys = view_of(std::as_const(sorted_keys_)),
                                            .leaves = view_of(std::as_const(sorted_leaves_)),
                                            .first = first,
                                            .group_bits = bits}});
        executor.for_each(count, Fill{visits, 0});
    }

private:
    template <class T>
    using Buffer = typename E::template Buffer<T>;

    TreeBuilder how_;
    Buffer<std::uint64_t> keys_, sorted_keys_;
    Buffer<std::uint32_t> leaves_, sorted_leaves_;
    Hlbvh<E> hlbvh_;
    Ploc<E> ploc_;
    TreeletRestructuring<E> restructuring_;
};

}  // namespace pierce::bvh
