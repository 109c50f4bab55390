#pragma once

#include <utility>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/execute/stage_traits.hpp"
#include "core/trace/bvh/candidates.hpp"
#include "core/trace/bvh/closest_candidates.hpp"
#include "core/trace/bvh/forest_builder.hpp"
#include "core/trace/bvh/forest_plan.hpp"
#include "core/trace/bvh/refit.hpp"
#include "core/trace/bvh/traversal.hpp"
#include "core/trace/bvh/tree_work.hpp"
#include "core/trace/tracer.hpp"

namespace pierce {
namespace bvh {

/// Per ray: its hit among its candidates; no hit if there are too many candidates.
struct Trace {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const Candidates> candidates;
    View<Hit> hits;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Ray ray = rays[i];
        hits[i] = {};
        const Candidates& known = candidates[i];
        const std::uint32_t count = known.count;
        if (count == 0 || count == Candidates::too_many) return;
        hits[i] = first_crossing(ray, bodies[ray.target].surface(), [&](CrossingSearch& search) {
            for (std::uint32_t k = 0; k < count; ++k) search.test(known.triangle[k]);
        });
    }
};

/// Per ray with too many candidates: its hit, through the tree. This is a separate launch, because
/// the few such rays would cost all other rays registers.
struct TraceTree {
    View<const BodyView> bodies;
    Forest forest;
    View<const Ray> rays;
    View<const Candidates> candidates;
    View<Hit> hits;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (candidates[i].count != Candidates::too_many) return;
        const Ray ray = rays[i];
        const BodyView& body = bodies[ray.target];
        hits[i] = first_crossing(ray, body.surface(), [&](CrossingSearch& search) {
            show_near(forest, forest.trees[forest.tree_of_body[ray.target]], body,
                      BoxRay(ray, positions_box(body), body.touch), search);
        });
    }
};

}  // namespace bvh

/// Our own trees on any executor: one per mesh of fixed and rigid bodies, and one per deforming
/// body, all built in one set of launches. The tree of a deforming body is refitted when the body's
/// positions have changed and the tree is wanted. All trees are rebuilt when bodies come or go and
/// when RefitPolicy finds a tree that has decayed. When few bodies get other meshes, these bodies'
/// trees become LBVHs, and the others stay.
template <Executor E>
class BvhTracer {
public:
    using Count = typename E::Count;

    explicit BvhTracer(TreeOptions trees = {})
        : builder_(trees.builder), rebuilds_(trees.rebuild) {}

    /// Decides which trees there must be. `bodies` are the bodies as the host sees them.
    void arrange(E& executor, View<const BodyView> bodies) {
        whole_or_anew([&] { arrange_trees(executor, bodies); });
    }

    /// Makes the trees of bodies with wanted[body] != 0 fit their positions.
    void update(E& executor, View<const BodyView> bodies, View<const std::uint32_t> wanted) {
        whole_or_anew([&] { update_trees(executor, bodies, wanted); });
    }

    /// Builds all trees anew.
    void build(E& executor, View<const BodyView> bodies) {
        bvh::Forest dense = forest();
        dense.trees.size = plan_.tree_count();
        dense.tree_of_leaf.size = plan_.leaf_count();
        builder_.build(executor, bodies, dense);
        executor.for_each(tree_count(), bvh::NoteFitted{bodies, view_of(trees_)});
        executor.assign(work_, tree_count(), bvh::TreeWork{});
        if (total_.empty()) executor.assign(total_, 1, bvh::ForestWork{});
        counts_.builds += plan_.tree_count();
        stale_ = false;
    }

    /// Builds the trees of bodies that have got other meshes since the last call, where others
    /// stay. Needs all that steps need of bodies but their bounds, which may be those of the last
    /// step.
    void build_changed(E& executor, View<const BodyView> bodies) {
        if (stale_ || changed_.empty()) return;
        const auto count = static_cast<std::uint32_t>(plan_.changed().size());
        // A tree may move to where another one was.
        for (const bvh::ChangedTree& changed : plan_.changed())
            executor.for_each(
                changed.count_before,
                bvh::Fill{leaves_of(changed.first_before, changed.count_before), bvh::no_tree});
        executor.for_each(count, bvh::ReplaceTree{.changed = view_of(std::as_const(changed_)),
                                                  .bodies = bodies,
                                                  .trees = view_of(trees_),
                                                  .work = view_of(work_)});
        for (const bvh::ChangedTree& changed : plan_.changed()) {
            executor.for_each(
                changed.tree.count,
                bvh::Fill{leaves_of(changed.tree.first, changed.tree.count), changed.place});
            builder_.build_one(executor, bodies, forest(), changed.tree.first, changed.tree.count);
        }
        counts_.builds += count;
        changed_.clear();
    }

    /// `before` and `after` are stages per ray, or NoStage, that run in the same launches.
    template <class Before = NoStage, class After = NoStage>
    void closest_hits(E& executor, View<const BodyView> bodies, Count count, View<const Ray> rays,
                      View<Hit> hits, const Before& before = {}, const After& after = {}) {
        candidates_.resize(count);
        executor.in_turn(count, before,
                         bvh::FindCandidates{.bodies = bodies,
                                             .forest = forest(),
                                             .rays = rays,
                                             .candidates = view_of(candidates_),
                                             .work = view_of(work_)},
                         bvh::Trace{.bodies = bodies,
                                    .rays = rays,
                                    .candidates = view_of(std::as_const(candidates_)),
                                    .hits = hits},
                         bvh::TraceTree{.bodies = bodies,
                                        .forest = forest(),
                                        .rays = rays,
                                        .candidates = view_of(std::as_const(candidates_)),
                                        .hits = hits},
                         after);
    }

    template <class Before = NoStage, class After = NoStage>
    void closest_triangles(E& executor, View<const BodyView> bodies, Count count,
                           View<const Ray> rays, View<std::uint32_t> triangles,
                           const Before& before = {}, const After& after = {}) {
        candidates_.resize(count);
        executor.in_turn(count, before,
                         bvh::FindClosestCandidates{.bodies = bodies,
                                                    .forest = forest(),
                                                    .rays = rays,
                                                    .candidates = view_of(candidates_)},
                         bvh::ClosestOfCandidates{.bodies = bodies,
                                                  .rays = rays,
                                                  .candidates = view_of(std::as_const(candidates_)),
                                                  .triangles = triangles},
                         bvh::ClosestInTree{.bodies = bodies,
                                            .forest = forest(),
                                            .rays = rays,
                                            .candidates = view_of(std::as_const(candidates_)),
                                            .triangles = triangles},
                         after);
    }

    /// True if the next update builds trees.
    bool is_stale() const { return stale_; }

    void add_up(E& executor) {
        if (!total_.empty())
            executor.reduce(1, bvh::ForestWorkSoFar{view_of(std::as_const(total_))}, added_up_);
    }
    /// If a tree has decayed since the last call, or trees are built in every step, the next update
    /// builds all of them.
    TracerCounts counts(const E& executor) {
        if (total_.empty()) return counts_;
        const bvh::ForestWork total = executor.read(added_up_);
        stale_ = stale_ || rebuilds_ || total.decayed != counts_.rebuilds;
        counts_.rebuilds = total.decayed;
        counts_.refits = total.refits;
        counts_.triangle_tests = total.tests;
        return counts_;
    }

private:
    template <class T>
    using Buffer = typename E::template Buffer<T>;

    /// Work that throws, as when memory runs out, may leave trees half made: the next call makes
    /// all of them.
    template <class Work>
    void whole_or_anew(const Work& work) {
        try {
            work();
        } catch (...) {
            plan_.forget();
            changed_.clear();
            stale_ = true;
            throw;
        }
    }

    void arrange_trees(E& executor, View<const BodyView> bodies) {
        if (stale_ && !plan_.is_dense()) plan_.forget();
        bvh::ForestPlan::Change change = plan_.arrange(bodies);
        if (stale_ && change == bvh::ForestPlan::Change::some) {
            // All trees are about to be built, one after the other.
            plan_.forget();
            change = plan_.arrange(bodies);
        }
        if (change == bvh::ForestPlan::Change::none) return;
        if (plan_.bodies_change_trees()) executor.upload(plan_.tree_of_body(), tree_of_body_);
        if (change == bvh::ForestPlan::Change::some) {
            executor.upload(plan_.changed(), changed_);
            return;
        }
        executor.upload(plan_.trees(), trees_);
        executor.upload(plan_.tree_of_leaf(), tree_of_leaf_);
        nodes_.resize(plan_.leaf_room());
        leaf_places_.resize(plan_.leaf_room());
        visits_.resize(plan_.leaf_room());
        changed_.clear();
        stale_ = true;
    }

    void update_trees(E& executor, View<const BodyView> bodies, View<const std::uint32_t> wanted) {
        if constexpr (E::traits.host_reads) {
            arrange_trees(executor, bodies);
        }
        if (stale_) return build(executor, bodies);
        build_changed(executor, bodies);
        executor.for_each(
            tree_count(),
            bvh::JudgeTree{view_of(work_), view_of(std::as_const(trees_)), view_of(total_)});
        executor.for_each(plan_.leaf_room(), bvh::Refit{bodies, wanted, forest()});
        executor.for_each(
            tree_count(),
            bvh::MarkFitted{
                .bodies = bodies, .wanted = wanted, .forest = forest(), .total = view_of(total_)});
    }

    std::uint32_t tree_count() const { return static_cast<std::uint32_t>(plan_.trees().size()); }

    View<std::uint32_t> leaves_of(std::uint32_t first, std::uint32_t count) {
        return {tree_of_leaf_.data() + first, count};
    }

    bvh::Forest forest() {
        return {.trees = view_of(trees_),
                .tree_of_body = view_of(std::as_const(tree_of_body_)),
                .tree_of_leaf = view_of(std::as_const(tree_of_leaf_)),
                .nodes = view_of(nodes_),
                .leaf_places = view_of(leaf_places_),
                .visits = view_of(visits_)};
    }

    bvh::ForestPlan plan_;
    bvh::ForestBuilder<E> builder_;
    bool rebuilds_ = false, stale_ = false;
    TracerCounts counts_;
    Buffer<bvh::Tree> trees_;
    Buffer<bvh::ChangedTree> changed_;
    Buffer<std::uint32_t> tree_of_body_, tree_of_leaf_;
    Buffer<bvh::Node> nodes_;
    Buffer<bvh::Place> leaf_places_;
    Buffer<std::uint32_t> visits_;
    Buffer<bvh::Candidates> candidates_;
    Buffer<bvh::TreeWork> work_;
    Buffer<bvh::ForestWork> total_;
    typename E::template Sum<bvh::ForestWork> added_up_{};
};

}  // namespace pierce
