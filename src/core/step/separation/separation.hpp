#pragma once

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/edge_chords.hpp"
#include "core/step/edges/late_chords.hpp"
#include "core/step/separation/ray_chains.hpp"
#include "core/step/separation/separation_lists.hpp"
#include "core/step/separation/separation_stages.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/join_batch.hpp"
#include "core/step/solids/ray_batch.hpp"
#include "core/step/solids/reprojection.hpp"

namespace pierce {

/// Finds pairs that overlap without a contact along an inward ray, and gives them contacts along
/// the direction in which they separate soonest.
template <Executor E, Tracer<E> T>
class Separation {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;
    using Count = typename E::Count;

    Separation(StepTools<E, T>& tools, Reprojection<E, T>& reprojection)
        : tools_(tools), executor_(tools.executor), late_chords_(tools, reprojection) {}

    /// Adds the rays of such pairs to `batch` and `routes`, those that start inside, as candidates
    /// that are contacts. Earlier candidates stay candidates.
    void separate(const StepOfPairs<E>& step, EdgeChords<E, T>& edges, RayBatch<E>& batch,
                  Buffer<Route>& routes) {
        late_rays_ = 0u;
        if (!step.scene.plan->is_complete()) {
            late_chords_.find(step, edges, batch, routes);
            late_rays_ = edges.chord_count();
        }
        inside_tests_ = rays_apart_ = touches_ = deep_pairs_ = 0u;
        executor_.when_any(
            step.count,
            stages::NeedsMore{.bodies = step.scene.bodies,
                              .directed = step.directed,
                              .marks = step.marks,
                              .inside_is_contact = step.scene.plan->settings.inside_is_contact()},
            [&] {
                edges.add_chords_at_ends(step);
                separate_stranded(step, edges, batch, routes);
                separate_touching(step, edges, batch, routes);
            });
    }

    /// How many rays were traced after all others in the last step: of chords in pairs that had no
    /// contact, and along ways apart.
    std::uint32_t late_rays() const {
        return executor_.number(late_rays_) + executor_.number(rays_apart_) +
               executor_.number(touches_);
    }
    /// How many inside tests of parts were traced in the last step.
    std::uint32_t inside_tests() const { return executor_.number(inside_tests_); }
    /// How many pairs of the last step overlap without a contact along an inward ray.
    std::uint32_t deep_pairs() const { return executor_.number(deep_pairs_); }

private:
    /// Adds rays along the way apart, from vertices and chords that are inside but whose pair has
    /// no contact, and from parts of bodies that are inside.
    void separate_stranded(const StepOfPairs<E>& step, EdgeChords<E, T>& edges, RayBatch<E>& batch,
                           Buffer<Route>& routes) {
        const View<const BodyView> bodies = step.scene.bodies;
        executor_.emit(
            ListId::parts, 2 * step.count,
            stages::AskParts{.bodies = bodies,
                             .directed = step.directed,
                             .marks = step.marks,
                             .inside_is_contact = step.scene.plan->settings.inside_is_contact()},
            parts_.rays, parts_.sources);
        executor_.emit(ListId::stranded_chords, edges.chord_count(),
                       stages::FindStrandedChords{.bodies = bodies,
                                                  .directed = step.directed,
                                                  .chords = edges.chords(),
                                                  .sources = edges.sources(),
                                                  .marks = step.marks},
                       chords_.rays, chords_.sources);
        executor_.emit(ListId::stranded_vertices, count_of(batch.candidates),
                       stages::FindStrandedVertices{.pairs = step.pairs,
                                                    .rays = view_of(batch.rays),
                                                    .sources = view_of(batch.sources),
                                                    .meetings = view_of(batch.meetings),
                                                    .candidates = view_of(batch.candidates),
                                                    .keep = view_of(batch.keep),
                                                    .marks = step.marks},
                       vertices_.middles, vertices_.sources);
        inside_tests_ = count_of(parts_.rays);
        if (executor_.is_empty(inside_tests_ + count_of(chords_.rays) +
                               count_of(vertices_.sources)))
            return;
        test_inside(step);
        choose_directions(step);
        cast_apart(step, edges);
        rays_apart_ = count_of(out_.rays);
        const Count candidates = count_of(batch.candidates);
        const stages::RayChains of_touching = new_chains(step, candidates);
        executor_.for_each(candidates,
                           stages::ChainTouchingVertices{.sources = view_of(batch.sources),
                                                         .candidates = view_of(batch.candidates),
                                                         .marks = step.marks,
                                                         .chains = of_touching});
        keep_inside(ListId::separated_rays, step, edges, batch, routes);
    }

    /// Adds rays from edges that lie in the other body's surface, or only touch it.
    void separate_touching(const StepOfPairs<E>& step, EdgeChords<E, T>& edges, RayBatch<E>& batch,
                           Buffer<Route>& routes) {
        const Count chords = edges.chord_count(), touching = edges.list_touching(step);
        if (executor_.is_empty(touching)) return;
        touches_ = edges.add_touching_chords(step, touching);
        if (executor_.is_empty(touches_)) return;
        out_.resize(touches_);
        executor_.for_each(
            touches_,
            stages::GenerateTouchingRays{
                .out = rays_apart(step, edges, 0u), .from = edges.sources(), .first = chords});
        keep_inside(ListId::touching_rays, step, edges, batch, routes);
    }

    /// Which of the listed parts, chords and vertices are inside.
    void test_inside(const StepOfPairs<E>& step) {
        const View<const BodyView> bodies = step.scene.bodies;
        trace(bodies, parts_);
        const stages::LeavesTarget leaves_target{bodies, view_of(parts_.rays),
                                                 view_of(parts_.hits)};
        const Count of_parts = count_of(parts_.rays);
        parts_.middles.resize(of_parts);
        executor_.for_each(of_parts,
                           stages::GenerateMiddlesOfParts{leaves_target, view_of(parts_.middles)});
        executor_.emit(ListId::contained_parts, of_parts,
                       stages::FindContained{.leaves = leaves_target,
                                             .sources = view_of(parts_.sources),
                                             .closest = closest(bodies, parts_),
                                             .marks = step.marks},
                       parts_.inside);
        trace(bodies, chords_);
        const stages::LeavesBoth leaves_both{bodies, view_of(chords_.rays), view_of(chords_.hits)};
        const Count of_chords = count_of(chords_.rays);
        chords_.middles.resize(of_chords);
        executor_.for_each(of_chords,
                           stages::GenerateMiddlesOfChords{leaves_both, view_of(chords_.middles)});
        executor_.emit(ListId::deep_chords, of_chords,
                       stages::FindDeepChords{.leaves = leaves_both,
                                              .sources = view_of(chords_.sources),
                                              .closest = closest(bodies, chords_),
                                              .marks = step.marks},
                       chords_.inside);
        executor_.emit(ListId::deep_vertices, count_of(vertices_.sources),
                       stages::FindDeepVertices{.sources = view_of(vertices_.sources),
                                                .closest = closest(bodies, vertices_),
                                                .marks = step.marks},
                       vertices_.inside);
    }
    /// The triangles that touch the middles of the ways inside.
    View<const std::uint32_t> closest(View<const BodyView> bodies, InsideTests<E>& tests) {
        tools_.update(bodies, tests.middles);
        return tools_.closest(bodies, tests.middles);
    }
    void trace(View<const BodyView> bodies, InsideTests<E>& tests) {
        tools_.update(bodies, tests.rays);
        tools_.trace(bodies, tests.rays, tests.hits);
    }

    /// The ways apart of the pairs that need one.
    void choose_directions(const StepOfPairs<E>& step) {
        deep_pairs_ = tools_.list(ListId::deep_pairs, step.count, stages::Separates{step.marks},
                                  apart_.pairs);
        apart_.directions.resize(step.count);
        executor_.for_each(deep_pairs_,
                           stages::FindSeparation{.bodies = step.scene.bodies,
                                                  .pairs = step.pairs,
                                                  .deep_pairs = view_of(apart_.pairs),
                                                  .directions = view_of(apart_.directions)});
    }

    /// Makes the rays along the ways apart.
    void cast_apart(const StepOfPairs<E>& step, EdgeChords<E, T>& edges) {
        const Count vertices = count_of(vertices_.inside), chords = count_of(chords_.inside),
                    contained = count_of(parts_.inside);
        constexpr std::uint32_t per_part = stages::GenerateContainedRays::per_part;
        out_.resize(vertices + chords + per_part * contained);
        executor_.for_each(vertices, stages::GenerateStrandedRays{rays_apart(step, edges, 0u),
                                                                  view_of(vertices_.inside)});
        executor_.for_each(chords, stages::GenerateStrandedRays{rays_apart(step, edges, vertices),
                                                                view_of(chords_.inside)});
        const stages::RayChains of_stranded = new_chains(step, vertices);
        executor_.for_each(vertices,
                           stages::ChainStrandedVertices{view_of(vertices_.inside), of_stranded});
        executor_.for_each(contained, stages::GenerateContainedRays{
                                          .out = rays_apart(step, edges, vertices + chords),
                                          .from = view_of(parts_.inside),
                                          .stranded = view_of(vertices_.inside),
                                          .chains = of_stranded});
    }

    /// Chains without any ray yet.
    stages::RayChains new_chains(const StepOfPairs<E>& step, const Count& rays) {
        executor_.assign(first_of_pair_, step.count, no_record);
        next_.resize(rays);
        return chains();
    }
    stages::RayChains chains() { return {view_of(first_of_pair_), view_of(next_)}; }

    stages::SeparationRays rays_apart(const StepOfPairs<E>& step, EdgeChords<E, T>& edges,
                                      const Count& begin) {
        return {.bodies = step.scene.bodies,
                .chords = edges.chords(),
                .directed = step.directed,
                .directions = view_of(apart_.directions),
                .begin = begin,
                .rays = view_of(out_.rays),
                .sources = view_of(out_.sources)};
    }

    /// Traces these rays; those that start inside are contacts.
    void keep_inside(ListId id, const StepOfPairs<E>& step, EdgeChords<E, T>& edges,
                     RayBatch<E>& batch, Buffer<Route>& routes) {
        const View<const BodyView> bodies = step.scene.bodies;
        tools_.update(bodies, out_.rays);
        tools_.trace(bodies, out_.rays, out_.hits);
        executor_.emit(id, count_of(out_.rays),
                       stages::TestInside{.bodies = bodies,
                                          .rays = view_of(out_.rays),
                                          .hits = view_of(out_.hits),
                                          .routes = {},
                                          .meetings = view_of(out_.meetings)},
                       out_.candidates);
        const Count inside = count_of(out_.candidates);
        executor_.for_each(
            inside, stages::JoinSeparated{
                        .inside = view_of(out_.candidates),
                        .batch = room_in(batch, routes, step.scene.plan->remembers(), inside, out_),
                        .marks = step.marks,
                        .flat = edges.flat(),
                        .touching = chains()});
    }

    StepTools<E, T>& tools_;
    E& executor_;
    LateChords<E, T> late_chords_;
    InsideTests<E> parts_, chords_, vertices_;
    WaysApart<E> apart_;
    RayBatch<E> out_;                             ///< along ways apart
    Buffer<std::uint32_t> first_of_pair_, next_;  ///< see stages::RayChains
    Count late_rays_ = 0u, rays_apart_ = 0u, touches_ = 0u, inside_tests_ = 0u, deep_pairs_ = 0u;
};

}  // namespace pierce
