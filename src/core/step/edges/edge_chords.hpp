#pragma once

#include <utility>

#include "core/body/scene.hpp"
#include "core/device/lanes.hpp"
#include "core/device/view.hpp"
#include "core/execute/stage_traits.hpp"
#include "core/step/common/bounds.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/asked_edges.hpp"
#include "core/step/edges/chord_stages.hpp"
#include "core/step/edges/edge_cull.hpp"
#include "core/step/edges/edge_lists.hpp"
#include "core/step/edges/near_edge.hpp"
#include "core/step/edges/near_edge_memory.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/edges/touch_stages.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_batch.hpp"
#include "core/step/solids/step_of_pairs.hpp"

namespace pierce {

/// Finds the parts of edges that are inside another body and adds a ray from the middle of each to
/// a batch of rays.
template <Executor E, Tracer<E> T>
class EdgeChords {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;
    using Count = typename E::Count;

    explicit EdgeChords(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// Boxes around the triangles of deforming bodies, before it is known which pairs are asked, if
    /// that costs nothing.
    void measure_boxes_early(const Scene& scene) {
        if constexpr (E::traits.overlaps_updates)
            executor_.beside([&] { measure_boxes(scene, {}); });
    }

    /// Finds the chords within edges, the parts of edges inside the other body of their pair. Makes
    /// room for their rays in `batch` and, if steps remember, in `routes`, and returns the stage
    /// per chord that writes them. Pairs with any of the marks `unless` are left out.
    stages::GenerateChordRays find(const StepOfPairs<E>& step, std::uint32_t unless,
                                   RayBatch<E>& batch, Buffer<Route>& routes) {
        look_within(step, unless);
        const Count begin = count_of(batch.rays), count = count_of(chords_.found);
        chords_.resize(count);
        batch.resize(begin + count);
        if (step.scene.plan->remembers()) routes.resize(begin + count);
        return {.bodies = step.scene.bodies,
                .directed = step.directed,
                .found = view_of(chords_.found),
                .begin = begin,
                .chords = chords_.views(step.marks),
                .rays = view_of(batch.rays),
                .sources = view_of(batch.sources),
                .hits = view_of(batch.hits),
                .routes = view_of(routes),
                .through = step.scene.plan->settings.inside_is_contact()};
    }

    /// For pairs that have no contact with a depth so far: appends the chords that hold an end of
    /// their edge. In other pairs these ends are in contact already, or near something that is.
    void add_chords_at_ends(const StepOfPairs<E>& step) {
        const stages::IsCrossed is_crossed{step.marks,
                                           step.scene.plan->settings.inside_is_contact()};
        if constexpr (!E::traits.joins_stages) {
            const Count pairs = tools_.list(ListId::crossed_pairs, step.count, is_crossed,
                                            scratch_.places);
            if (executor_.is_empty(pairs)) return;
        }
        find_chords(ListId::chords_at_ends,
                    stages::MayCrossOne{view_of(std::as_const(now_.edges)), is_crossed},
                    chords_of(step, stages::Chords::at_ends));
        keep(step, count_of(chords_.found), {}, 0);
    }

    /// Lists the edges of pairs whose edges touch and that have no contact so far, as is possible
    /// with aligned bodies; returns how many there are.
    Count list_touching(const StepOfPairs<E>& step) {
        return tools_.list(ListId::touching_edges, count_of(now_.edges),
                           stages::OnlyTouches{.directed = step.directed,
                                               .near = view_of(std::as_const(now_.edges)),
                                               .marks = step.marks},
                           scratch_.places);
    }

    /// Looks at the `touching` edges that list_touching() has listed as if one body had moved a
    /// little forward and, if that shows no overlap, a little back. Appends the chords where both
    /// bodies have an inside, and returns how many there are.
    Count add_touching_chords(const StepOfPairs<E>& step, const Count& touching) {
        const Count forward = add_moved(step, touching, 1.0, ListId::chords_forward);
        return forward + add_moved(step, list_touching(step), -1.0, ListId::chords_back);
    }

    /// Of all chords found in this step: those within their edges come first.
    View<const Chord> chords() const { return view_of(chords_.all); }
    View<const RaySource> sources() const { return view_of(chords_.sources); }
    View<std::uint32_t> flat() { return view_of(chords_.flat); }
    Count chord_count() const { return count_of(chords_.all); }

    /// Clears what an earlier step has left: there is nothing in this one so far.
    void forget() {
        now_.clear();
        chords_.resize(0u);
    }

    /// How many edges were near the other body of their pair.
    Count near_edges() const { return count_of(now_.edges); }

    /// Makes room for `count` more chords at the end; returns all chords.
    View<Chord> add_room(const Count& count) {
        chords_.resize(chord_count() + count);
        return view_of(chords_.all);
    }

    /// Boxes around the triangles of deforming targets of some groups of edges, if they are not
    /// measured early: then the caller joins.
    void measure_boxes_of(const StepOfPairs<E>& step, const Buffer<stages::CullItem>& groups) {
        if constexpr (!E::traits.overlaps_updates)
            measure_boxes_that_are_wanted(step, groups, [] {});
    }

    /// Makes what this step remembers what the last step has left.
    void recall() { std::swap(now_, last_); }

private:
    void measure_boxes(const Scene& scene, View<const std::uint32_t> wanted) {
        for (std::uint32_t level = 0; level < BoxLevels::most; ++level) {
            const std::uint32_t begin = scene.level_begin[level];
            const std::uint32_t count = scene.level_begin[level + 1] - begin;
            executor_.for_each(executor_.in_sixteens(count),
                               stages::MeasureNode{.bodies = scene.bodies,
                                                   .items = {scene.node_items.data + begin, count},
                                                   .nodes = scene.box_nodes,
                                                   .wanted = wanted});
        }
    }

    /// The boxes of the targets that edges may reach, if they were not measured early.
    void measure_boxes_in_reach(const StepOfPairs<E>& step) {
        if constexpr (E::traits.overlaps_updates) return executor_.join();
        measure_boxes_that_are_wanted(step, near_.groups, [&] {
            if (!step.scene.plan->remembers()) return;
            executor_.for_each(
                2 * step.count,
                stages::MarkTargetsOfKept{step.directed, view_of(std::as_const(now_.of_pairs)),
                                          view_of(scratch_.wanted)});
        });
    }

    /// Measures the boxes of the targets of `groups`, and of what `mark_more` marks in `wanted`.
    template <class MarkMore>
    void measure_boxes_that_are_wanted(const StepOfPairs<E>& step,
                                       const Buffer<stages::CullItem>& groups,
                                       const MarkMore& mark_more) {
        if (step.scene.node_items.size == 0) return;
        executor_.assign(scratch_.wanted, step.scene.bodies.size, 0u);
        executor_.for_each(
            count_of(groups),
            stages::MarkTargetsOfGroups{step.directed, view_of(groups), view_of(scratch_.wanted)});
        mark_more();
        measure_boxes(step.scene, view_of(std::as_const(scratch_.wanted)));
    }

    /// Finds the chords within edges.
    void look_within(const StepOfPairs<E>& step, std::uint32_t unless) {
        const bool remembers = step.scene.plan->remembers();
        const stages::PairsAsked asked{step.marks, unless};
        near_.gaps.clear();
        if (remembers) recall_pairs(step, asked);
        cull(step, asked);
        if (remembers) merge(step);
        find_chords(ListId::chords,
                    stages::MayCross{.bodies = step.scene.bodies,
                                     .directed = step.directed,
                                     .of_pairs = view_of(std::as_const(now_.of_pairs)),
                                     .near = view_of(now_.edges),
                                     .asked = asked},
                    chords_of(step, stages::Chords::within));
    }

    /// How to find chords of near edges.
    stages::FindChords chords_of(const StepOfPairs<E>& step, stages::Chords wanted) {
        return {.bodies = step.scene.bodies,
                .directed = step.directed,
                .near = view_of(now_.edges),
                .of_pairs = view_of(std::as_const(now_.of_pairs)),
                .places = {},
                .wanted = wanted,
                .marks = step.marks};
    }

    /// Finds chords of the near edges that are wanted.
    template <class Wanted>
    void find_chords(ListId id, const Wanted& wanted, stages::FindChords chords) {
        if constexpr (E::traits.joins_stages) {
            const FindWanted find(wanted, chords);
            const Count edges = count_of(now_.edges);
            if (executor_.are_few_in_lanes(edges))
                executor_.emit(id, executor_.in_lanes(edges), FindApart(find), chords_.found);
            else
                executor_.emit(id, edges, find, chords_.found);
        } else {
            const Count asked = tools_.list(ListId::asked_edges, count_of(now_.edges), wanted,
                                            scratch_.places);
            chords.places = view_of(std::as_const(scratch_.places));
            executor_.emit(id, asked, chords, chords_.found);
        }
    }

    /// Finds chords of moved edges, those listed in the scratch memory, and appends those where
    /// both bodies have an inside; returns how many these are.
    Count add_moved(const StepOfPairs<E>& step, const Count& edges, double sign, ListId id) {
        stages::FindChords chords = chords_of(step, stages::Chords::all);
        chords.of_pairs = {};
        chords.places = view_of(std::as_const(scratch_.places));
        chords.move = sign;
        executor_.emit(id, edges, chords, chords_.found);
        const Count count = count_of(chords_.found);
        scratch_.rays.resize(2 * count);
        executor_.for_each(count, stages::GenerateTouchRays{.bodies = step.scene.bodies,
                                                            .directed = step.directed,
                                                            .found = view_of(chords_.found),
                                                            .rays = view_of(scratch_.rays)});
        tools_.update(step.scene.bodies, scratch_.rays);
        tools_.trace(step.scene.bodies, scratch_.rays, scratch_.hits);
        const Count kept = tools_.list(ListId::deep_touches, count,
                                       stages::LeavesBoth{.bodies = step.scene.bodies,
                                                          .rays = view_of(scratch_.rays),
                                                          .hits = view_of(scratch_.hits),
                                                          .otherwise = false},
                                       scratch_.deep);
        keep(step, kept, view_of(std::as_const(scratch_.deep)), stages::PairMarks::moved_overlaps);
        return kept;
    }

    /// Appends chords that were found, all of them or those at the given places.
    void keep(const StepOfPairs<E>& step, const Count& count, View<const std::uint32_t> places,
              std::uint32_t mark) {
        const Count begin = count_of(chords_.all);
        chords_.resize(begin + count);
        executor_.for_each(count, stages::KeepChord{.found = view_of(chords_.found),
                                                    .places = places,
                                                    .begin = begin,
                                                    .chords = chords_.views(step.marks),
                                                    .mark = mark});
    }

    /// Which pairs' near edges are still those of the last step.
    void recall_pairs(const StepOfPairs<E>& step, const stages::PairsAsked& asked) {
        const Count directions = 2 * step.count;
        now_.of_pairs.resize(directions);
        near_.gaps.resize(directions);
        executor_.for_each(directions,
                           stages::RecallNearEdges{.bodies = step.scene.bodies,
                                                   .directed = step.directed,
                                                   .asked = asked,
                                                   .memory = step.memory,
                                                   .links = step.links,
                                                   .last = view_of(std::as_const(last_.of_pairs)),
                                                   .now = view_of(now_.of_pairs),
                                                   .gaps = view_of(near_.gaps)});
    }

    /// Which edges are near triangles of the other body of their pair, of pairs that are asked
    /// anew.
    void cull(const StepOfPairs<E>& step, const stages::PairsAsked& asked) {
        const View<const BodyView> bodies = step.scene.bodies;
        const bool remembers = step.scene.plan->remembers();
        executor_.emit(ListId::edge_blocks, 2 * step.count,
                       stages::ListEdgeBlocks{.bodies = bodies,
                                              .directed = step.directed,
                                              .of_pairs = view_of(std::as_const(now_.of_pairs)),
                                              .asked = asked},
                       near_.blocks);
        executor_.emit(ListId::edge_groups, count_of(near_.blocks),
                       stages::CullEdgeBlock{.bodies = bodies,
                                             .directed = step.directed,
                                             .blocks = view_of(near_.blocks),
                                             .gaps = view_of(near_.gaps)},
                       near_.groups);
        measure_boxes_in_reach(step);
        constexpr bool in_two = E::traits.joins_stages;
        Buffer<NearEdge>& found = remembers ? near_.found : now_.edges;
        tools_.share_out(count_of(near_.groups), [&](auto share, const Count& groups) {
            executor_.emit(ListId::found_edges, groups,
                           stages::FindNearEdges<decltype(share)>{.bodies = bodies,
                                                                  .directed = step.directed,
                                                                  .groups = view_of(near_.groups),
                                                                  .gaps = view_of(near_.gaps),
                                                                  .asks_boxes = !in_two},
                           in_two ? near_.in_spheres : found);
        });
        // Where an item is a thread, edges of a group would wait for each other.
        if constexpr (in_two)
            executor_.emit(ListId::edges_in_boxes, count_of(near_.in_spheres),
                           stages::KeepNearBoxes{.bodies = bodies,
                                                 .directed = step.directed,
                                                 .edges = view_of(near_.in_spheres),
                                                 .gaps = view_of(near_.gaps)},
                           found);
        if (remembers)
            executor_.for_each(2 * step.count,
                               stages::ExpireNearEdges{.bodies = bodies,
                                                       .directed = step.directed,
                                                       .asked = asked,
                                                       .gaps = view_of(std::as_const(near_.gaps)),
                                                       .of_pairs = view_of(now_.of_pairs)});
    }

    /// The near edges of all pairs, kept or found anew.
    void merge(const StepOfPairs<E>& step) {
        executor_.for_each(count_of(near_.found),
                           stages::CountNearEdges{.found = view_of(std::as_const(near_.found)),
                                                  .total = count_of(near_.found),
                                                  .of_pairs = view_of(now_.of_pairs)});
        executor_.emit(
            ListId::near_edges, 2 * step.count,
            stages::MergeNearEdges{.bodies = step.scene.bodies,
                                   .directed = step.directed,
                                   .memory = step.memory,
                                   .links = step.links,
                                   .last_of_pairs = view_of(std::as_const(last_.of_pairs)),
                                   .found = view_of(std::as_const(near_.found)),
                                   .last = view_of(std::as_const(last_.edges)),
                                   .of_pairs = view_of(now_.of_pairs)},
            now_.edges);
    }

    StepTools<E, T>& tools_;
    E& executor_;
    NearEdgeMemory<E> now_, last_;
    NearEdgeLists<E> near_;
    ChordLists<E> chords_;
    EdgeScratch<E> scratch_;
};

}  // namespace pierce
