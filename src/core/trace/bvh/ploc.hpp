#pragma once

#include <utility>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/trace/bvh/lbvh.hpp"
#include "pierce/min_max.hpp"

/// Parallel locally-ordered clustering (Meister and Bittner, TVCG 2018): clusters are in the order
/// of a Morton curve. Two clusters that are each other's nearest join, until each tree is one
/// cluster.
namespace pierce::bvh {

/// A subtree that looks for another one to join.
struct Cluster {
    Item item;
    BoxF box;
    std::uint32_t tree = 0;
    std::uint32_t slot = 0;  ///< the first of its leaves' places. Each place but a tree's first
                             ///< stands for one node: the node before it
};

/// Per place in sorted order: a cluster of one leaf.
struct LeafClusters {
    View<const BodyView> bodies;
    Forest forest;
    View<const std::uint32_t> leaves;  ///< sorted
    View<Cluster> clusters;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t t = forest.tree_of_leaf[leaves[i]];
        const Tree& tree = forest.trees[t];
        const std::uint32_t leaf = leaves[i] - tree.first;
        clusters[i] = {.item = Item::leaf(leaf),
                       .box = leaf_box(bodies[tree.body], leaf),
                       .tree = t,
                       .slot = i};
    }
};

/// Per cluster: the nearby cluster of the same tree with which it has the smallest box. Of several,
/// it is the one whose place differs in the lowest bits. So each tree has two clusters that choose
/// each other, and if all clusters are alike, every two do.
struct FindNearest {
    View<const Cluster> clusters;
    std::uint32_t count = 0;
    View<std::uint32_t> nearest;  ///< itself: none

    PIERCE_HD void operator()(std::uint32_t i) const {
        constexpr std::uint32_t radius = constants::cluster_radius;
        const Cluster cluster = clusters[i];
        const std::uint32_t begin = i < radius ? 0 : i - radius,
                            end = min_of(count, i + radius + 1);
        std::uint32_t best = i;
        float least = INFINITY;
        for (std::uint32_t j = begin; j < end; ++j) {
            if (j == i || clusters[j].tree != cluster.tree) continue;
            // Both clusters see the same area even if the boxes hold NaN: the area is then
            // infinite.
            const BoxF both = j < i ? join(clusters[j].box, cluster.box)
                                    : join(cluster.box, clusters[j].box);
            const float area = min_of(both.half_area(), INFINITY);
            if (best != i && (area > least || (area == least && (j ^ i) > (best ^ i)))) continue;
            best = j;
            least = area;
        }
        nearest[i] = best;
    }
};

/// True for clusters that stay in the list: all but the second of two that join.
struct StaysCluster {
    View<const std::uint32_t> nearest;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        return nearest[i] >= i || nearest[nearest[i]] != i;
    }
};

/// Per cluster that stays: joins it with the cluster it chose, if that one chose it, too.
struct JoinClusters {
    Forest forest;
    View<const Cluster> clusters;
    View<const std::uint32_t> nearest;
    View<const std::uint32_t> places;  ///< of clusters that stay
    View<Cluster> joined;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t place = places[i], other = nearest[place];
        Cluster cluster = clusters[place];
        if (other != place && nearest[other] == place) {
            const Cluster& second = clusters[other];
            const Tree& tree = forest.trees[cluster.tree];
            const std::uint32_t node = max_of(cluster.slot, second.slot) - 1;
            set_child(forest, tree, Place::at(node, 0), cluster.item, cluster.box);
            set_child(forest, tree, Place::at(node, 1), second.item, second.box);
            cluster.item = Item::node(node);
            cluster.box.extend(second.box);
            cluster.slot = min_of(cluster.slot, second.slot);
        }
        joined[i] = cluster;
    }
};

/// Per cluster that is a whole tree: makes it the tree's root.
struct RootClusters {
    Forest forest;
    View<const Cluster> clusters;

    PIERCE_HD void operator()(std::uint32_t i) const {
        set_root(forest, forest.trees[clusters[i].tree], clusters[i].item);
    }
};

/// Builds all trees of a forest from sorted leaves.
template <Executor E>
class Ploc {
public:
    void build(E& executor, View<const BodyView> bodies, const Forest& forest,
               View<const std::uint32_t> leaves) {
        std::uint32_t count = leaves.size;
        clusters_.resize(count);
        joined_.resize(count);
        nearest_.resize(count);
        places_.resize(count);
        executor.for_each(count, LeafClusters{.bodies = bodies,
                                              .forest = forest,
                                              .leaves = leaves,
                                              .clusters = view_of(clusters_)});
        while (count > forest.trees.size) {
            const auto clusters = view_of(std::as_const(clusters_));
            const auto nearest = view_of(std::as_const(nearest_)),
                       places = view_of(std::as_const(places_));
            executor.for_each(count, FindNearest{clusters, count, view_of(nearest_)});
            count = executor.number(executor.select(ListId::tree_clusters, count,
                                                    StaysCluster{nearest}, view_of(places_)));
            executor.for_each(count, JoinClusters{.forest = forest,
                                                  .clusters = clusters,
                                                  .nearest = nearest,
                                                  .places = places,
                                                  .joined = view_of(joined_)});
            std::swap(clusters_, joined_);
        }
        executor.for_each(count, RootClusters{forest, view_of(std::as_const(clusters_))});
    }

private:
    template <class T>
    using Buffer = typename E::template Buffer<T>;

    Buffer<Cluster> clusters_, joined_;
    Buffer<std::uint32_t> nearest_, places_;
};

}  // namespace pierce::bvh
