#pragma once

#include <cstdint>
#include <utility>

#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/edge_chords.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/join_batch.hpp"
#include "core/step/solids/ray_batch.hpp"
#include "core/step/solids/reprojection.hpp"

namespace pierce {

namespace stages {

/// Per candidate of late rays: decides whether it is a contact, and joins the batch.
struct JoinLate {
    TestOwnExit own_exit;
    JoinBatch batch;

    PIERCE_HD void operator()(std::uint32_t i) const {
        own_exit(i);
        batch.join(i, own_exit.candidates[i], own_exit.keep[i]);
    }
};

}  // namespace stages

/// Looks for chords in pairs in which no vertex has a contact that shows a way out, and takes their
/// rays through trace, classify and reproject.
template <Executor E, Tracer<E> T>
class LateChords {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    LateChords(StepTools<E, T>& tools, Reprojection<E, T>& reprojection)
        : tools_(tools), executor_(tools.executor), reprojection_(reprojection) {}

    /// Adds their rays that start inside to the batch, as candidates.
    void find(const StepOfPairs<E>& step, EdgeChords<E, T>& edges, RayBatch<E>& batch,
              Buffer<Route>& routes) {
        const View<const BodyView> bodies = step.scene.bodies;
        late_.clear();
        late_routes_.clear();
        const stages::GenerateChordRays generate = edges.find(step, stages::PairMarks::has_way_out,
                                                              late_, late_routes_);
        const auto count = count_of(late_.rays);
        tools_.trace_between(bodies, late_.rays, late_.hits, generate, NoStage{});
        const bool own_exits = !step.scene.plan->settings.inside_is_contact();
        const stages::TestInside inside{.bodies = bodies,
                                        .rays = view_of(late_.rays),
                                        .hits = view_of(late_.hits),
                                        .routes = {},
                                        .meetings = view_of(late_.meetings)};
        own_rays_.clear();
        if (own_exits)
            executor_.emit(ListId::late_candidates, count,
                           stages::GenerateOwnRays{.inside_target = inside,
                                                   .pairs = step.pairs,
                                                   .chords = edges.chords(),
                                                   .sources = view_of(late_.sources)},
                           late_.candidates, own_rays_, starts_inside_);
        else
            executor_.emit(ListId::late_candidates, count, inside, late_.candidates);
        const auto begin = count_of(batch.candidates), found = count_of(late_.candidates);
        if (executor_.is_empty(found)) return;
        late_.keep.resize(found);
        own_hits_.resize(count_of(own_rays_));
        const stages::JoinLate join{
            .own_exit = {.bodies = bodies,
                         .rays = view_of(late_.rays),
                         .meetings = view_of(late_.meetings),
                         .candidates = view_of(late_.candidates),
                         .own_rays = view_of(own_rays_),
                         .own_hits = view_of(own_hits_),
                         .starts_inside = view_of(starts_inside_),
                         .keep = view_of(late_.keep)},
            .batch = room_in(batch, routes, step.scene.plan->remembers(), found, late_)};
        if (own_exits)
            tools_.trace_between(bodies, own_rays_, own_hits_, NoStage{}, join);
        else
            executor_.for_each(found, join);
        reprojection_.decide(step, batch, begin, found, edges.chords(), edges.flat(),
                             view_of(std::as_const(routes)));
    }

private:
    StepTools<E, T>& tools_;
    E& executor_;
    Reprojection<E, T>& reprojection_;
    RayBatch<E> late_;
    Buffer<Route> late_routes_;
    Buffer<Ray> own_rays_;
    Buffer<Hit> own_hits_;
    Buffer<std::uint32_t> starts_inside_;
};

}  // namespace pierce
