#pragma once

#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/chord_stages.hpp"
#include "core/step/edges/edge_cull.hpp"
#include "core/step/edges/edge_lists.hpp"
#include "core/step/edges/touch_stages.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_batch.hpp"

namespace pierce {

/// Casts the edges that may reach another body and adds a ray from the middle of each part inside
/// it to the step's rays.
template <Executor E, Tracer<E> T>
class EdgeChords {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    explicit EdgeChords(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// Which edges may reach the other body of their pair, by patches, then one by one.
    void cull(const Scene& scene, View<const stages::DirectedPair> directed,
              View<const stages::CullItem> blocks) {
        cull_.masks.resize(blocks.size);
        scratch_.counts.resize(blocks.size);
        executor_.for_each(blocks.size, stages::CullEdgeBlock{.bodies = scene.bodies,
                                                              .directed = directed,
                                                              .blocks = blocks,
                                                              .masks = view_of(cull_.masks),
                                                              .counts = view_of(scratch_.counts)});
        cull_.patches.resize(tools_.place(ListId::edge_patches, scratch_.counts, scratch_.offsets));
        executor_.for_each(blocks.size,
                           stages::ListEdgePatches{.blocks = blocks,
                                                   .masks = view_of(cull_.masks),
                                                   .offsets = view_of(scratch_.offsets),
                                                   .patches = view_of(cull_.patches)});
        const auto kept = static_cast<std::uint32_t>(cull_.patches.size());
        scratch_.counts.resize(kept);
        executor_.for_each(kept, stages::CountEdgeGroups{.bodies = scene.bodies,
                                                         .directed = directed,
                                                         .patches = view_of(cull_.patches),
                                                         .counts = view_of(scratch_.counts)});
        cull_.groups.resize(tools_.place(ListId::edge_groups, scratch_.counts, scratch_.offsets));
        executor_.for_each(kept, stages::ListEdgeGroups{.bodies = scene.bodies,
                                                        .directed = directed,
                                                        .patches = view_of(cull_.patches),
                                                        .offsets = view_of(scratch_.offsets),
                                                        .groups = view_of(cull_.groups)});
        const auto group_count = static_cast<std::uint32_t>(cull_.groups.size());
        cull_.masks.resize(group_count);
        scratch_.counts.resize(group_count);
        executor_.for_each(group_count, stages::CullEdgeGroup{.bodies = scene.bodies,
                                                              .directed = directed,
                                                              .groups = view_of(cull_.groups),
                                                              .masks = view_of(cull_.masks),
                                                              .counts = view_of(scratch_.counts)});
        cull_.items.resize(tools_.place(ListId::edges, scratch_.counts, scratch_.offsets));
        executor_.for_each(group_count, stages::ListEdges{.groups = view_of(cull_.groups),
                                                          .masks = view_of(cull_.masks),
                                                          .offsets = view_of(scratch_.offsets),
                                                          .items = view_of(cull_.items)});
        const auto count = static_cast<std::uint32_t>(cull_.items.size());
        cull_.spans.resize(count);
        executor_.for_each(count, stages::CullEdge{.bodies = scene.bodies,
                                                   .directed = directed,
                                                   .items = view_of(cull_.items),
                                                   .spans = view_of(cull_.spans)});

        const std::uint32_t near = tools_.list(ListId::near_edges, count,
                                               stages::MayReach{view_of(cull_.spans)}, cull_.slots);
        segments_.all.resize(near);
        segments_.rays.resize(near);
        segments_.active.resize(near);
        executor_.for_each(near, stages::GenerateSegments{.bodies = scene.bodies,
                                                          .directed = directed,
                                                          .items = view_of(cull_.items),
                                                          .spans = view_of(cull_.spans),
                                                          .slots = view_of(cull_.slots),
                                                          .segments = view_of(segments_.all),
                                                          .rays = view_of(segments_.rays),
                                                          .active = view_of(segments_.active)});
    }

    /// The rays along the edges that are left.
    const Buffer<Ray>& segments() const { return segments_.rays; }

    /// Follows every edge from crossing to crossing, and adds the rays of its chords to `batch` and
    /// `routes`.
    void cast(const Scene& scene, View<const stages::DirectedPair> directed, RayBatch<E>& batch,
              Buffer<Route>& routes) {
        find_chords(scene, directed);
        const auto begin = static_cast<std::uint32_t>(batch.rays.size()),
                   count = static_cast<std::uint32_t>(chords_.found.size());
        tools_.sort(64, chords_.keys, chords_.unsorted, chords_.sorted_keys, chords_.order);
        chords_.all.resize(count);
        batch.resize(begin + count);
        if (scene.plan->remembers()) routes.resize(begin + count);
        executor_.for_each(count, stages::GenerateChordRays{.bodies = scene.bodies,
                                                            .directed = directed,
                                                            .items = view_of(cull_.items),
                                                            .segments = view_of(segments_.all),
                                                            .found = view_of(chords_.found),
                                                            .order = view_of(chords_.order),
                                                            .begin = begin,
                                                            .chords = view_of(chords_.all),
                                                            .rays = view_of(batch.rays),
                                                            .sources = view_of(batch.sources),
                                                            .hits = view_of(batch.hits),
                                                            .routes = view_of(routes)});
    }

    /// For pairs whose edges touch and that have no contact so far (`contact`, per pair), as is
    /// possible with aligned bodies: casts the edges again as if one body had moved a little, once
    /// forward and once back. Appends the chords where both bodies have an inside, and writes their
    /// sources.
    void add_touching_chords(const Scene& scene, View<const stages::DirectedPair> directed,
                             View<const std::uint32_t> contact, Buffer<RaySource>& sources) {
        sources.clear();
        for (const double sign : {1.0, -1.0}) {
            const std::uint32_t again = tools_.list(
                ListId::touching_segments, count_of(segments_.all),
                stages::OnlyTouches{.items = view_of(cull_.items),
                                    .segments = view_of(segments_.all),
                                    .touching = view_of(segments_.touching),
                                    .contact = contact},
                segments_.active);
            if (again == 0) return;
            executor_.for_each(again, stages::NudgeSegment{.bodies = scene.bodies,
                                                           .directed = directed,
                                                           .items = view_of(cull_.items),
                                                           .spans = view_of(cull_.spans),
                                                           .again = view_of(segments_.active),
                                                           .sign = sign,
                                                           .segments = view_of(segments_.all),
                                                           .rays = view_of(segments_.rays)});
            chords_.found.clear();
            tools_.update(scene.bodies, segments_.rays);
            follow(scene, directed, chords_.found);
            const auto count = static_cast<std::uint32_t>(chords_.found.size());
            scratch_.now_rays.resize(2 * std::size_t{count});
            executor_.for_each(count,
                               stages::GenerateTouchRays{.bodies = scene.bodies,
                                                         .directed = directed,
                                                         .items = view_of(cull_.items),
                                                         .segments = view_of(segments_.all),
                                                         .found = view_of(chords_.found),
                                                         .rays = view_of(scratch_.now_rays)});
            tools_.update(scene.bodies, scratch_.now_rays);
            tools_.trace(scene.bodies, scratch_.now_rays, scratch_.now_hits);
            const std::uint32_t kept = tools_.list(
                ListId::deep_touches, count,
                stages::LeavesBoth{.bodies = scene.bodies,
                                   .rays = view_of(scratch_.now_rays),
                                   .hits = view_of(scratch_.now_hits),
                                   .otherwise = false},
                scratch_.places);
            const auto chords = static_cast<std::uint32_t>(chords_.all.size()),
                       before = static_cast<std::uint32_t>(sources.size());
            chords_.all.resize(chords + kept);
            sources.resize(before + kept);
            executor_.for_each(kept, stages::KeepTouch{.items = view_of(cull_.items),
                                                       .segments = view_of(segments_.all),
                                                       .found = view_of(chords_.found),
                                                       .places = view_of(scratch_.places),
                                                       .begin = chords,
                                                       .chords = view_of(chords_.all),
                                                       .sources = {sources.data() + before, kept}});
        }
    }

    View<const Chord> chords() const { return view_of(chords_.all); }

    /// Clears the chords: there are none in this step.
    void forget() { chords_.all.clear(); }

private:
    void find_chords(const Scene& scene, View<const stages::DirectedPair> directed) {
        segments_.finished.resize(count_of(segments_.all));
        executor_.assign(segments_.touching, directed.size / 2, 0u);
        chords_.found.clear();
        follow(scene, directed, chords_.found);
        const auto count = static_cast<std::uint32_t>(chords_.found.size());
        chords_.keys.resize(count);
        chords_.unsorted.resize(count);
        executor_.for_each(count, stages::KeyChord{view_of(chords_.found), view_of(chords_.keys),
                                                   view_of(chords_.unsorted)});
    }

    /// Follows the active segments from crossing to crossing, and appends their chords to `found`.
    void follow(const Scene& scene, View<const stages::DirectedPair> directed,
                Buffer<stages::FoundChord>& found) {
        while (!segments_.active.empty()) {
            const auto count = static_cast<std::uint32_t>(segments_.active.size());
            scratch_.now_rays.resize(count);
            chords_.now_found.resize(count);
            scratch_.counts.resize(count);
            executor_.for_each(
                count, stages::Gather<Ray>{view_of(segments_.rays), view_of(segments_.active),
                                           view_of(scratch_.now_rays)});
            tools_.trace(scene.bodies, scratch_.now_rays, scratch_.now_hits);
            executor_.for_each(count,
                               stages::AdvanceSegment{.bodies = scene.bodies,
                                                      .directed = directed,
                                                      .items = view_of(cull_.items),
                                                      .spans = view_of(cull_.spans),
                                                      .active = view_of(segments_.active),
                                                      .hits = view_of(scratch_.now_hits),
                                                      .segments = view_of(segments_.all),
                                                      .rays = view_of(segments_.rays),
                                                      .counts = view_of(scratch_.counts),
                                                      .found = view_of(chords_.now_found),
                                                      .finished = view_of(segments_.finished),
                                                      .touching = view_of(segments_.touching)});
            const auto begin = static_cast<std::uint32_t>(found.size());
            found.resize(begin + tools_.place(ListId::chords, scratch_.counts, scratch_.offsets));
            executor_.for_each(count, stages::KeepChord{.counts = view_of(scratch_.counts),
                                                        .offsets = view_of(scratch_.offsets),
                                                        .found = view_of(chords_.now_found),
                                                        .begin = begin,
                                                        .chords = view_of(found)});
            const std::uint32_t left = tools_.list(
                ListId::active_segments, count,
                stages::GoesOn{view_of(segments_.active), view_of(segments_.finished)},
                scratch_.places);
            segments_.next_active.resize(left);
            executor_.for_each(left, stages::Gather<std::uint32_t>{view_of(segments_.active),
                                                                   view_of(scratch_.places),
                                                                   view_of(segments_.next_active)});
            std::swap(segments_.active, segments_.next_active);
        }
    }

    StepTools<E, T>& tools_;
    E& executor_;
    EdgeCullLists<E> cull_;
    EdgeSegmentLists<E> segments_;
    ChordLists<E> chords_;
    EdgeScratch<E> scratch_;
};

}  // namespace pierce
