#pragma once

#include <utility>

#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/bounds.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/asked_edges.hpp"
#include "core/step/edges/chord_stages.hpp"
#include "core/step/edges/edge_cull.hpp"
#include "core/step/edges/edge_lists.hpp"
#include "core/step/edges/near_edge_memory.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/edges/touch_stages.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_batch.hpp"

namespace pierce {

/// Finds the parts of edges that are inside another body and adds a ray from the middle of each to
/// the step's rays.
template <Executor E, Tracer<E> T>
class EdgeChords {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;
    using Count = typename E::Count;

    explicit EdgeChords(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// Finds the edges' chords, the parts of them inside the other body of their pair, and adds
    /// their rays to `batch` and `routes`. Pairs with `has_depth` are left out, if that is not
    /// empty.
    void find(const Scene& scene, View<const stages::DirectedPair> directed,
              View<const PairMemory> memory, View<const std::uint32_t> links,
              View<const std::uint32_t> has_depth, RayBatch<E>& batch, Buffer<Route>& routes) {
        look_within(scene, directed, memory, links, has_depth);
        const auto begin = static_cast<std::uint32_t>(batch.rays.size()),
                   count = static_cast<std::uint32_t>(chords_.found.size());
        chords_.all.resize(count);
        batch.resize(begin + count);
        if (scene.plan->remembers()) routes.resize(begin + count);
        executor_.for_each(count, stages::GenerateChordRays{.bodies = scene.bodies,
                                                            .directed = directed,
                                                            .found = view_of(chords_.found),
                                                            .begin = begin,
                                                            .chords = view_of(chords_.all),
                                                            .rays = view_of(batch.rays),
                                                            .sources = view_of(batch.sources),
                                                            .hits = view_of(batch.hits),
                                                            .routes = view_of(routes)});
    }

    /// For pairs that have no contact with a depth so far: appends the chords that hold an end of
    /// their edge, and their sources. In other pairs these ends are in contact already, or near
    /// something that is.
    void add_chords_at_ends(const Scene& scene, View<const stages::DirectedPair> directed,
                            View<const std::uint32_t> has_depth, Buffer<RaySource>& sources) {
        const stages::IsCrossed is_crossed{view_of(std::as_const(crossed_)), has_depth};
        const std::uint32_t pairs = tools_.list(ListId::crossed_pairs, directed.size / 2,
                                                is_crossed, scratch_.places);
        if (pairs == 0) return;
        const std::uint32_t asked = tools_.list(
            ListId::asked_edges, count_of(now_.edges),
            stages::MayCrossOne{view_of(std::as_const(now_.edges)), is_crossed}, scratch_.places);
        executor_.emit(ListId::chords, asked,
                       stages::FindChords{.bodies = scene.bodies,
                                          .directed = directed,
                                          .near = view_of(now_.edges),
                                          .of_pairs = view_of(std::as_const(now_.of_pairs)),
                                          .places = view_of(scratch_.places),
                                          .wanted = stages::Chords::at_ends,
                                          .touching = view_of(touching_),
                                          .crossed_pairs = {}},
                       chords_.found);
        const auto chords = static_cast<std::uint32_t>(chords_.all.size()),
                   count = static_cast<std::uint32_t>(chords_.found.size()),
                   before = static_cast<std::uint32_t>(sources.size());
        chords_.all.resize(chords + count);
        sources.resize(before + count);
        executor_.for_each(count, stages::KeepChord{.found = view_of(chords_.found),
                                                    .places = {},
                                                    .begin = chords,
                                                    .chords = view_of(chords_.all),
                                                    .sources = {sources.data() + before, count},
                                                    .moved = {}});
    }

    /// For pairs whose edges touch and that have no contact so far (`contact`, per pair), as is
    /// possible with aligned bodies: looks at the edges again as if one body had moved a little
    /// forward and, if that shows no overlap, a little back. Appends the chords where both bodies
    /// have an inside, and writes their sources.
    void add_touching_chords(const Scene& scene, View<const stages::DirectedPair> directed,
                             View<const std::uint32_t> contact, Buffer<RaySource>& sources) {
        sources.clear();
        executor_.assign(moved_, directed.size / 2, 0u);
        for (const double sign : {1.0, -1.0}) {
            const std::uint32_t again = tools_.list(
                ListId::touching_edges, count_of(now_.edges),
                stages::OnlyTouches{.directed = directed,
                                    .near = view_of(std::as_const(now_.edges)),
                                    .touching = view_of(touching_),
                                    .contact = contact,
                                    .moved = view_of(std::as_const(moved_))},
                scratch_.places);
            if (again == 0) return;
            executor_.emit(ListId::chords, again,
                           stages::FindChords{.bodies = scene.bodies,
                                              .directed = directed,
                                              .near = view_of(now_.edges),
                                              .of_pairs = {},
                                              .places = view_of(scratch_.places),
                                              .move = sign,
                                              .wanted = stages::Chords::all,
                                              .touching = view_of(touching_),
                                              .crossed_pairs = {}},
                           chords_.found);
            const auto count = static_cast<std::uint32_t>(chords_.found.size());
            scratch_.rays.resize(2 * std::size_t{count});
            executor_.for_each(count, stages::GenerateTouchRays{.bodies = scene.bodies,
                                                                .directed = directed,
                                                                .found = view_of(chords_.found),
                                                                .rays = view_of(scratch_.rays)});
            tools_.update(scene.bodies, scratch_.rays);
            tools_.trace(scene.bodies, scratch_.rays, scratch_.hits);
            const std::uint32_t kept = tools_.list(
                ListId::deep_touches, count,
                stages::LeavesBoth{.bodies = scene.bodies,
                                   .rays = view_of(scratch_.rays),
                                   .hits = view_of(scratch_.hits),
                                   .otherwise = false},
                scratch_.places);
            const auto chords = static_cast<std::uint32_t>(chords_.all.size()),
                       before = static_cast<std::uint32_t>(sources.size());
            chords_.all.resize(chords + kept);
            sources.resize(before + kept);
            executor_.for_each(kept, stages::KeepChord{.found = view_of(chords_.found),
                                                       .places = view_of(scratch_.places),
                                                       .begin = chords,
                                                       .chords = view_of(chords_.all),
                                                       .sources = {sources.data() + before, kept},
                                                       .moved = view_of(moved_)});
        }
    }

    View<const Chord> chords() const { return view_of(chords_.all); }

    /// Clears what an earlier step has left: there is nothing in this one so far.
    void forget() {
        now_.clear();
        chords_.all.clear();
    }

    /// How many edges were near the other body of their pair.
    Count near_edges() const { return count_of(now_.edges); }

    /// Makes what this step remembers what the last step has left.
    void recall() { std::swap(now_, last_); }

private:
    /// Finds the chords within edges.
    void look_within(const Scene& scene, View<const stages::DirectedPair> directed,
                     View<const PairMemory> memory, View<const std::uint32_t> links,
                     View<const std::uint32_t> has_depth) {
        measure_boxes(scene);
        const bool remembers = scene.plan->remembers();
        near_.gaps.clear();
        if (remembers) recall_pairs(scene, directed, memory, links, has_depth);
        cull(scene, directed, has_depth);
        if (remembers) merge(scene, directed, memory, links);
        executor_.assign(touching_, directed.size / 2, 0u);
        executor_.assign(crossed_, directed.size / 2, 0u);
        const Count asked = tools_.list(
            ListId::asked_edges, count_of(now_.edges),
            stages::MayCross{.bodies = scene.bodies,
                             .directed = directed,
                             .of_pairs = view_of(std::as_const(now_.of_pairs)),
                             .near = view_of(now_.edges),
                             .crossed_pairs = view_of(crossed_)},
            scratch_.places);
        executor_.emit(ListId::chords, asked,
                       stages::FindChords{.bodies = scene.bodies,
                                          .directed = directed,
                                          .near = view_of(now_.edges),
                                          .of_pairs = view_of(std::as_const(now_.of_pairs)),
                                          .places = view_of(scratch_.places),
                                          .touching = view_of(touching_),
                                          .crossed_pairs = view_of(crossed_)},
                       chords_.found);
    }

    /// Boxes around the triangles of deforming bodies.
    void measure_boxes(const Scene& scene) {
        for (std::uint32_t level = 0; level < BoxLevels::most; ++level) {
            const std::uint32_t begin = scene.level_begin[level];
            executor_.for_each(scene.level_begin[level + 1] - begin,
                               stages::MeasureNode{.bodies = scene.bodies,
                                                   .items = {scene.node_items.data + begin,
                                                             scene.level_begin[level + 1] - begin},
                                                   .nodes = scene.box_nodes});
        }
    }

    /// Which pairs' near edges are still those of the last step.
    void recall_pairs(const Scene& scene, View<const stages::DirectedPair> directed,
                      View<const PairMemory> memory, View<const std::uint32_t> links,
                      View<const std::uint32_t> has_depth) {
        now_.of_pairs.resize(directed.size);
        near_.gaps.resize(directed.size);
        executor_.for_each(directed.size,
                           stages::RecallNearEdges{.bodies = scene.bodies,
                                                   .directed = directed,
                                                   .has_depth = has_depth,
                                                   .memory = memory,
                                                   .links = links,
                                                   .last = view_of(std::as_const(last_.of_pairs)),
                                                   .now = view_of(now_.of_pairs),
                                                   .gaps = view_of(near_.gaps)});
    }

    /// Which edges are near triangles of the other body of their pair, of pairs that are asked
    /// anew.
    void cull(const Scene& scene, View<const stages::DirectedPair> directed,
              View<const std::uint32_t> has_depth) {
        const bool remembers = scene.plan->remembers();
        executor_.emit(ListId::edge_blocks, Count{directed.size},
                       stages::ListEdgeBlocks{.bodies = scene.bodies,
                                              .directed = directed,
                                              .of_pairs = view_of(std::as_const(now_.of_pairs)),
                                              .has_depth = has_depth},
                       near_.blocks);
        executor_.emit(ListId::edge_groups, count_of(near_.blocks),
                       stages::CullEdgeBlock{.bodies = scene.bodies,
                                             .directed = directed,
                                             .blocks = view_of(near_.blocks),
                                             .gaps = view_of(near_.gaps)},
                       near_.groups);
        executor_.emit(ListId::found_edges, count_of(near_.groups),
                       stages::FindNearEdges{.bodies = scene.bodies,
                                             .directed = directed,
                                             .groups = view_of(near_.groups),
                                             .gaps = view_of(near_.gaps)},
                       remembers ? near_.found : now_.edges);
        if (remembers)
            executor_.for_each(directed.size,
                               stages::ExpireNearEdges{.bodies = scene.bodies,
                                                       .directed = directed,
                                                       .has_depth = has_depth,
                                                       .gaps = view_of(std::as_const(near_.gaps)),
                                                       .of_pairs = view_of(now_.of_pairs)});
    }

    /// The near edges of all pairs, kept or found anew.
    void merge(const Scene& scene, View<const stages::DirectedPair> directed,
               View<const PairMemory> memory, View<const std::uint32_t> links) {
        executor_.for_each(
            count_of(near_.found),
            stages::CountNearEdges{view_of(std::as_const(near_.found)), view_of(now_.of_pairs)});
        executor_.emit(
            ListId::near_edges, Count{directed.size},
            stages::MergeNearEdges{.bodies = scene.bodies,
                                   .directed = directed,
                                   .memory = memory,
                                   .links = links,
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
    Buffer<std::uint32_t> touching_;  ///< per pair: an edge touches the other surface
    Buffer<std::uint32_t> crossed_;   ///< per pair: an edge may cross the other surface
    Buffer<std::uint32_t> moved_;     ///< per pair: an edge that was moved shows an overlap
    EdgeScratch<E> scratch_;
};

}  // namespace pierce
