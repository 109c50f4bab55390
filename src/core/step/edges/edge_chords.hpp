#pragma once

#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/edge_stages.hpp"
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
        masks_.resize(blocks.size);
        counts_.resize(blocks.size);
        executor_.for_each(blocks.size, stages::CullEdgeBlock{.bodies = scene.bodies,
                                                              .directed = directed,
                                                              .blocks = blocks,
                                                              .masks = view_of(masks_),
                                                              .counts = view_of(counts_)});
        patches_.resize(tools_.place(ListId::edge_patches, counts_, offsets_));
        executor_.for_each(blocks.size, stages::ListEdgePatches{.blocks = blocks,
                                                                .masks = view_of(masks_),
                                                                .offsets = view_of(offsets_),
                                                                .patches = view_of(patches_)});
        const auto kept = static_cast<std::uint32_t>(patches_.size());
        counts_.resize(kept);
        executor_.for_each(kept, stages::CountEdgeGroups{.bodies = scene.bodies,
                                                         .directed = directed,
                                                         .patches = view_of(patches_),
                                                         .counts = view_of(counts_)});
        groups_.resize(tools_.place(ListId::edge_groups, counts_, offsets_));
        executor_.for_each(kept, stages::ListEdgeGroups{.bodies = scene.bodies,
                                                        .directed = directed,
                                                        .patches = view_of(patches_),
                                                        .offsets = view_of(offsets_),
                                                        .groups = view_of(groups_)});
        const auto group_count = static_cast<std::uint32_t>(groups_.size());
        masks_.resize(group_count);
        counts_.resize(group_count);
        executor_.for_each(group_count, stages::CullEdgeGroup{.bodies = scene.bodies,
                                                              .directed = directed,
                                                              .groups = view_of(groups_),
                                                              .masks = view_of(masks_),
                                                              .counts = view_of(counts_)});
        items_.resize(tools_.place(ListId::edges, counts_, offsets_));
        executor_.for_each(group_count, stages::ListEdges{.groups = view_of(groups_),
                                                          .masks = view_of(masks_),
                                                          .offsets = view_of(offsets_),
                                                          .items = view_of(items_)});
        const auto count = static_cast<std::uint32_t>(items_.size());
        spans_.resize(count);
        executor_.for_each(count, stages::CullEdge{.bodies = scene.bodies,
                                                   .directed = directed,
                                                   .items = view_of(items_),
                                                   .spans = view_of(spans_)});

        const std::uint32_t near = tools_.list(ListId::near_edges, count,
                                               stages::MayReach{view_of(spans_)}, slots_);
        segments_.resize(near);
        rays_.resize(near);
        active_.resize(near);
        executor_.for_each(near, stages::GenerateSegments{.bodies = scene.bodies,
                                                          .directed = directed,
                                                          .items = view_of(items_),
                                                          .spans = view_of(spans_),
                                                          .slots = view_of(slots_),
                                                          .segments = view_of(segments_),
                                                          .rays = view_of(rays_),
                                                          .active = view_of(active_)});
    }

    /// The rays along the edges that are left.
    const Buffer<Ray>& segments() const { return rays_; }

    /// Follows every edge from crossing to crossing, and adds the rays of its chords to `batch` and
    /// `routes`.
    void cast(const Scene& scene, View<const stages::DirectedPair> directed, RayBatch<E>& batch,
              Buffer<Route>& routes) {
        find_chords(scene, directed);
        const auto begin = static_cast<std::uint32_t>(batch.rays.size()),
                   count = static_cast<std::uint32_t>(found_.size());
        tools_.sort(64, keys_, unsorted_, sorted_keys_, order_);
        chords_.resize(count);
        batch.resize(begin + count);
        if (scene.plan->remembers()) routes.resize(begin + count);
        executor_.for_each(count, stages::GenerateChordRays{.bodies = scene.bodies,
                                                            .directed = directed,
                                                            .items = view_of(items_),
                                                            .segments = view_of(segments_),
                                                            .found = view_of(found_),
                                                            .order = view_of(order_),
                                                            .begin = begin,
                                                            .chords = view_of(chords_),
                                                            .rays = view_of(batch.rays),
                                                            .sources = view_of(batch.sources),
                                                            .hits = view_of(batch.hits),
                                                            .routes = view_of(routes)});
    }

    /// Of pairs whose edges touch and that have no contact so far (`contact`, per pair), as aligned
    /// bodies may: casts the edges again as if one body had moved a little, there and back. Appends
    /// the chords where both bodies have an inside, and writes their sources.
    void add_touching_chords(const Scene& scene, View<const stages::DirectedPair> directed,
                             View<const std::uint32_t> contact, Buffer<RaySource>& sources) {
        sources.clear();
        for (const double sign : {1.0, -1.0}) {
            const std::uint32_t again = tools_.list(
                ListId::touching_segments, count_of(segments_),
                stages::OnlyTouches{.items = view_of(items_),
                                    .segments = view_of(segments_),
                                    .touching = view_of(touching_),
                                    .contact = contact},
                active_);
            if (again == 0) return;
            executor_.for_each(again, stages::NudgeSegment{.bodies = scene.bodies,
                                                           .directed = directed,
                                                           .items = view_of(items_),
                                                           .spans = view_of(spans_),
                                                           .again = view_of(active_),
                                                           .sign = sign,
                                                           .segments = view_of(segments_),
                                                           .rays = view_of(rays_)});
            found_.clear();
            tools_.update(scene.bodies, rays_);
            follow(scene, directed, found_);
            const auto count = static_cast<std::uint32_t>(found_.size());
            now_rays_.resize(2 * std::size_t{count});
            executor_.for_each(count, stages::GenerateTouchRays{.bodies = scene.bodies,
                                                                .directed = directed,
                                                                .items = view_of(items_),
                                                                .segments = view_of(segments_),
                                                                .found = view_of(found_),
                                                                .rays = view_of(now_rays_)});
            tools_.update(scene.bodies, now_rays_);
            tools_.trace(scene.bodies, now_rays_, now_hits_);
            const std::uint32_t kept = tools_.list(ListId::deep_touches, count,
                                                   stages::LeavesBoth{.bodies = scene.bodies,
                                                                      .rays = view_of(now_rays_),
                                                                      .hits = view_of(now_hits_),
                                                                      .otherwise = false},
                                                   places_);
            const auto chords = static_cast<std::uint32_t>(chords_.size()),
                       before = static_cast<std::uint32_t>(sources.size());
            chords_.resize(chords + kept);
            sources.resize(before + kept);
            executor_.for_each(kept, stages::KeepTouch{.items = view_of(items_),
                                                       .segments = view_of(segments_),
                                                       .found = view_of(found_),
                                                       .places = view_of(places_),
                                                       .begin = chords,
                                                       .chords = view_of(chords_),
                                                       .sources = {sources.data() + before, kept}});
        }
    }

    View<const Chord> chords() const { return view_of(chords_); }

    /// There are no chords in this step.
    void forget() { chords_.clear(); }

private:
    void find_chords(const Scene& scene, View<const stages::DirectedPair> directed) {
        finished_.resize(count_of(segments_));
        executor_.assign(touching_, directed.size / 2, 0u);
        found_.clear();
        follow(scene, directed, found_);
        const auto count = static_cast<std::uint32_t>(found_.size());
        keys_.resize(count);
        unsorted_.resize(count);
        executor_.for_each(count,
                           stages::KeyChord{view_of(found_), view_of(keys_), view_of(unsorted_)});
    }

    /// Follows the active segments from crossing to crossing, and appends their chords to `found`.
    void follow(const Scene& scene, View<const stages::DirectedPair> directed,
                Buffer<stages::FoundChord>& found) {
        while (!active_.empty()) {
            const auto count = static_cast<std::uint32_t>(active_.size());
            now_rays_.resize(count);
            now_found_.resize(count);
            counts_.resize(count);
            executor_.for_each(
                count, stages::Gather<Ray>{view_of(rays_), view_of(active_), view_of(now_rays_)});
            tools_.trace(scene.bodies, now_rays_, now_hits_);
            executor_.for_each(count, stages::AdvanceSegment{.bodies = scene.bodies,
                                                             .directed = directed,
                                                             .items = view_of(items_),
                                                             .spans = view_of(spans_),
                                                             .active = view_of(active_),
                                                             .hits = view_of(now_hits_),
                                                             .segments = view_of(segments_),
                                                             .rays = view_of(rays_),
                                                             .counts = view_of(counts_),
                                                             .found = view_of(now_found_),
                                                             .finished = view_of(finished_),
                                                             .touching = view_of(touching_)});
            const auto begin = static_cast<std::uint32_t>(found.size());
            found.resize(begin + tools_.place(ListId::chords, counts_, offsets_));
            executor_.for_each(count, stages::KeepChord{.counts = view_of(counts_),
                                                        .offsets = view_of(offsets_),
                                                        .found = view_of(now_found_),
                                                        .begin = begin,
                                                        .chords = view_of(found)});
            const std::uint32_t left = tools_.list(
                ListId::active_segments, count,
                stages::GoesOn{view_of(active_), view_of(finished_)}, places_);
            next_active_.resize(left);
            executor_.for_each(left,
                               stages::Gather<std::uint32_t>{view_of(active_), view_of(places_),
                                                             view_of(next_active_)});
            std::swap(active_, next_active_);
        }
    }

    StepTools<E, T>& tools_;
    E& executor_;
    Buffer<std::uint32_t> masks_, counts_, offsets_, slots_, active_, next_active_, places_,
        finished_, unsorted_, order_, touching_;
    Buffer<std::uint64_t> keys_, sorted_keys_;
    Buffer<stages::CullItem> patches_;
    Buffer<stages::EdgeGroup> groups_;
    Buffer<stages::EdgeItem> items_;
    Buffer<stages::Span> spans_;
    Buffer<stages::Segment> segments_;
    Buffer<Ray> rays_, now_rays_;
    Buffer<Hit> now_hits_;
    Buffer<stages::FoundChord> now_found_, found_;
    Buffer<Chord> chords_;
};

}  // namespace pierce
