#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/base/places.hpp"
#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/trace/bvh/forest.hpp"

namespace pierce::bvh {

/// A tree that is new in its place, and where the tree that had its place before had its leaves.
struct ChangedTree {
    Tree tree;
    std::uint32_t place = 0;  ///< among the forest's trees
    std::uint32_t first_before = 0, count_before = 0;
};

/// Decides which trees a scene needs: one per mesh that fixed or rigid bodies have, one per
/// deforming body. When a few bodies have got other meshes, the others' trees stay where they are.
class ForestPlan {
public:
    enum class Change { none, some, all };

    /// Looks at the bodies' meshes and kinds only. Says which trees must be built.
    Change arrange(View<const BodyView> bodies);

    /// The next call of arrange() lays all trees out anew.
    void forget() { seen_.clear(); }

    /// With room for more, which have no leaves.
    std::span<const Tree> trees() const { return trees_; }
    std::span<const std::uint32_t> tree_of_body() const { return tree_of_body_; }
    /// With room for more, which belong to no tree.
    std::span<const std::uint32_t> tree_of_leaf() const { return tree_of_leaf_; }
    std::uint32_t leaf_room() const { return places_.room(); }
    /// How many trees and leaves there are, one after the other; after a change of some trees this
    /// is no longer known.
    std::uint32_t tree_count() const { return tree_count_; }
    std::uint32_t leaf_count() const { return leaf_count_; }
    /// True if all trees are laid out one after the other.
    bool is_dense() const { return is_dense_; }
    /// True if the last call of arrange() gave a body another body's tree, or one of its own.
    bool bodies_change_trees() const { return bodies_change_trees_; }
    /// The trees that the last call of arrange() changed, if only some.
    std::span<const ChangedTree> changed() const { return changed_; }

private:
    struct Seen {
        std::uint64_t mesh_key = 0;
        Motion motion = Motion::fixed;

        friend bool operator==(const Seen&, const Seen&) = default;
    };

    void lay_out(View<const BodyView> bodies);
    bool change(View<const BodyView> bodies, std::span<const std::uint32_t> of_bodies);
    std::uint32_t shared_tree(const BodyView& body, std::uint32_t before);

    std::vector<Seen> seen_;  ///< per body
    std::vector<Tree> trees_;
    std::vector<std::uint32_t> users_;  ///< per tree: bodies that have it
    std::vector<std::uint32_t> tree_of_body_, tree_of_leaf_;
    std::unordered_map<std::uint64_t, std::uint32_t> tree_of_mesh_;  ///< of bodies that keep their
                                                                     ///< shape
    Places places_;                                                  ///< of the trees' leaves
    std::uint32_t tree_count_ = 0, leaf_count_ = 0;
    std::vector<ChangedTree> changed_;
    bool meshes_change_ = false;  ///< a body has got another mesh
    bool is_dense_ = true, bodies_change_trees_ = true;
};

}  // namespace pierce::bvh
