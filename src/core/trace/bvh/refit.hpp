#pragma once

#include "core/body/body_view.hpp"
#include "core/device/atomics.hpp"
#include "core/device/view.hpp"
#include "core/trace/bvh/forest.hpp"
#include "core/trace/bvh/forest_plan.hpp"
#include "core/trace/bvh/tree_work.hpp"

namespace pierce::bvh {

/// Which positions a tree has just been built for. Those of a body that takes no part may not be
/// here yet, as on a device, although its version is known.
PIERCE_HD inline std::uint64_t fitted_when_built(const BodyView& body) {
    return body.active ? body.positions_version : Tree::fits_nothing;
}

/// True if a tree's boxes no longer fit and the tree is wanted. What the caller writes in device
/// memory changes without a word.
PIERCE_HD inline bool needs_refit(const Tree& tree, const BodyView& body,
                                  View<const std::uint32_t> wanted) {
    return tree.moves && wanted[tree.body] && body.active &&
           (tree.fitted != body.positions_version || body.device_positions != nullptr);
}

/// Per leaf: writes its box, and climbs as long as it is the second to reach each node.
struct Refit {
    View<const BodyView> bodies;
    View<const std::uint32_t> wanted;  ///< per body
    Forest forest;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t t = forest.tree_of_leaf[i];
        if (t == no_tree) return;
        const Tree& tree = forest.trees[t];
        const BodyView& body = bodies[tree.body];
        if (!needs_refit(tree, body, wanted)) return;
        BoxF box = leaf_box(body, i - tree.first);
        for (Place place = forest.leaf_places[i]; !place.is_root();
             place = forest.nodes[place.node()].parent) {
            Node& node = forest.nodes[place.node()];
            node.box[place.side()] = box;
            // A refit visits a node twice: the thread that comes first stops here.
            if (atomic_add(forest.visits[place.node()], 1) % 2 == 0) return;
            box = join(box, node.box[1 - place.side()]);
        }
    }
};

/// Per tree, after Refit: notes which positions it fits now. Counts the trees that changed.
struct MarkFitted {
    View<const BodyView> bodies;
    View<const std::uint32_t> wanted;
    Forest forest;
    View<ForestWork> total;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t t) const {
        Tree& tree = forest.trees[t];
        if (!needs_refit(tree, bodies[tree.body], wanted)) return;
        tree.fitted = bodies[tree.body].positions_version;
        atomic_add(total[0].refits, 1);
    }
};

/// Per tree, after all were built: notes which positions it fits.
struct NoteFitted {
    View<const BodyView> bodies;
    View<Tree> trees;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t t) const {
        if (trees[t].moves) trees[t].fitted = fitted_when_built(bodies[trees[t].body]);
    }
};

/// Per tree of a body that has got another mesh: the new tree takes the old one's place, and is
/// built before it is asked.
struct ReplaceTree {
    View<const ChangedTree> changed;
    View<const BodyView> bodies;
    View<Tree> trees;
    View<TreeWork> work;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        Tree tree = changed[i].tree;
        if (tree.moves) tree.fitted = fitted_when_built(bodies[tree.body]);
        trees[changed[i].place] = tree;
        work[changed[i].place] = {};
    }
};

}  // namespace pierce::bvh
