#pragma once

#include "core/device/atomics.hpp"
#include "core/device/view.hpp"
#include "core/trace/bvh/forest.hpp"
#include "core/trace/refit_policy.hpp"

namespace pierce::bvh {

/// What rays have cost a tree since it was built.
struct TreeWork {
    std::uint32_t rays = 0, nodes = 0, tests = 0;  ///< since they were last judged
    RefitPolicy policy;
};

/// What the trees have cost so far, and whether some must be rebuilt.
struct ForestWork {
    std::uint64_t tests = 0;
    std::uint32_t refits = 0;
    std::uint32_t decayed = 0;  ///< trees for which a rebuild pays

    PIERCE_HD friend ForestWork operator+(const ForestWork& a, const ForestWork& b) {
        return {a.tests + b.tests, a.refits + b.refits, a.decayed + b.decayed};
    }
};

/// The forest's work as a sum of one term, which the host can read.
struct ForestWorkSoFar {
    View<const ForestWork> total;

    PIERCE_HD ForestWork operator()(std::uint32_t i) const { return total[i]; }
};

/// Per tree, before it is refitted again: notes whether its refit has decayed. A visit to a node
/// counts like a test of a triangle. Without the nodes, decay would not show: every leaf fits its
/// own box, whatever became of the boxes above.
struct JudgeTree {
    View<TreeWork> work;
    View<const Tree> trees;
    View<ForestWork> total;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t t) const {
        if (!trees[t].moves || work[t].rays == 0) return;
        TreeWork& tree = work[t];
        const bool before = tree.policy.should_rebuild(trees[t].count);
        tree.policy.record(tree.rays, std::uint64_t{tree.nodes} + tree.tests);
        atomic_add(total[0].tests, std::uint64_t{tree.tests});
        tree.rays = tree.nodes = tree.tests = 0;
        if (!before && tree.policy.should_rebuild(trees[t].count)) atomic_add(total[0].decayed, 1);
    }
};

}  // namespace pierce::bvh
