#pragma once

#include <span>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/trace/bvh/forest.hpp"

namespace pierce::bvh {

/// Decides which trees a scene needs: one per mesh that fixed or rigid bodies have, one per
/// deforming body.
class ForestPlan {
public:
    /// Looks at the bodies' meshes and kinds only. True if anything has changed.
    bool arrange(View<const BodyView> bodies);

    std::span<const Tree> trees() const { return trees_; }
    std::span<const std::uint32_t> tree_of_body() const { return tree_of_body_; }
    std::span<const std::uint32_t> tree_of_leaf() const { return tree_of_leaf_; }
    std::uint32_t leaf_count() const { return static_cast<std::uint32_t>(tree_of_leaf_.size()); }

private:
    struct Seen {
        std::uint64_t mesh_key = 0;
        Motion motion = Motion::fixed;

        friend bool operator==(const Seen&, const Seen&) = default;
    };

    std::vector<Seen> seen_;  ///< per body
    std::vector<Tree> trees_;
    std::vector<std::uint32_t> tree_of_body_, tree_of_leaf_;
};

}  // namespace pierce::bvh
