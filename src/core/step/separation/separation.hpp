#pragma once

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/edge_chords.hpp"
#include "core/step/separation/separation_stages.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_batch.hpp"

namespace pierce {

/// Finds pairs that overlap without a contact along an inward ray, and gives them contacts along
/// the direction in which they separate soonest.
template <Executor E, Tracer<E> T>
class Separation {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    explicit Separation(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// Adds the rays of such pairs to `batch` and `routes`; those that start inside become
    /// candidates that are contacts. What was a candidate so far stays one.
    void separate(const Scene& scene, View<const Pair> pairs,
                  View<const stages::DirectedPair> directed, EdgeChords<E, T>& edges,
                  RayBatch<E>& batch, Buffer<Route>& routes) {
        add_stranded(scene, pairs, directed, edges.chords(), batch, routes);
        add_touching(scene, directed, edges, batch, routes);
    }

    /// Inside tests of parts that were traced in the last step.
    std::uint32_t inside_tests() const { return inside_tests_; }
    /// Pairs of the last step that overlap without a contact along an inward ray.
    std::uint32_t deep_pairs() const { return deep_count_; }

private:
    /// Vertices and chords inside whose pair has no contact, and parts of bodies inside, along the
    /// way apart.
    void add_stranded(const Scene& scene, View<const Pair> pairs,
                      View<const stages::DirectedPair> directed, View<const Chord> chords,
                      RayBatch<E>& batch, Buffer<Route>& routes) {
        const auto candidates = static_cast<std::uint32_t>(batch.candidates.size());
        const auto all = static_cast<std::uint32_t>(batch.rays.size());
        const View<const RaySource> sources = view_of(std::as_const(batch.sources));
        const View<const RaySource> from_chords{sources.data + (all - chords.size), chords.size};
        executor_.assign(reached_, pairs.size, 0u);
        executor_.assign(touching_, pairs.size, 0u);
        executor_.for_each(candidates, stages::MarkTouching{.sources = sources,
                                                            .candidates = view_of(batch.candidates),
                                                            .keep = view_of(batch.keep),
                                                            .reached = view_of(reached_),
                                                            .touching = view_of(touching_)});
        executor_.for_each(chords.size, stages::MarkReached{from_chords, view_of(reached_)});
        test_parts(scene, directed);
        const std::uint32_t stranded_chords = list_stranded_chords(scene, directed, chords,
                                                                   from_chords);
        const std::uint32_t vertices = tools_.list(
            ListId::stranded_vertices, candidates,
            stages::IsStrandedVertex{.pairs = pairs,
                                     .sources = sources,
                                     .candidates = view_of(batch.candidates),
                                     .touching = view_of(touching_)},
            stranded_vertices_);
        const std::uint32_t stranded = vertices + stranded_chords;
        const auto contained = static_cast<std::uint32_t>(contained_.size());
        deep_count_ = 0;
        if (stranded + contained == 0) return;

        // Sources are copied: the list they come from will grow.
        gather_.resize(vertices);
        from_.resize(stranded + contained);
        executor_.for_each(
            vertices, stages::Gather<std::uint32_t>{view_of(batch.candidates),
                                                    view_of(stranded_vertices_), view_of(gather_)});
        executor_.for_each(vertices,
                           stages::Gather<RaySource>{sources, view_of(gather_), view_of(from_)});
        executor_.for_each(stranded - vertices, stages::Gather<RaySource>{from_chords,
                                                                          view_of(stranded_chords_),
                                                                          {from_.data() + vertices,
                                                                           stranded - vertices}});
        executor_.for_each(
            contained,
            stages::Gather<RaySource>{
                view_of(part_sources_), view_of(contained_), {from_.data() + stranded, contained}});
        executor_.assign(deep_, pairs.size, 0u);
        executor_.for_each(stranded + contained,
                           stages::MarkReached{view_of(from_), view_of(deep_)});
        deep_count_ = tools_.list(ListId::deep_pairs, pairs.size, stages::IsDeep{view_of(deep_)},
                                  deep_pairs_);
        directions_.resize(pairs.size);
        executor_.for_each(deep_count_, stages::FindSeparation{.bodies = scene.bodies,
                                                               .pairs = pairs,
                                                               .deep_pairs = view_of(deep_pairs_),
                                                               .directions = view_of(directions_)});

        const std::uint32_t added = stranded + contained * stages::GenerateContainedRays::per_part;
        const stages::SeparationRays out = room_for(added, scene, directed, chords, batch, routes);
        executor_.for_each(stranded, stages::GenerateStrandedRays{out, view_of(from_)});
        executor_.for_each(contained, stages::GenerateContainedRays{
                                          out, {from_.data() + stranded, contained}, stranded});
        keep_inside(scene, out.begin, batch);
    }

    /// Edges that lie in the other body's surface, or only touch it.
    void add_touching(const Scene& scene, View<const stages::DirectedPair> directed,
                      EdgeChords<E, T>& edges, RayBatch<E>& batch, Buffer<Route>& routes) {
        edges.add_touching_chords(scene, directed, view_of(touching_), from_);
        const auto touches = static_cast<std::uint32_t>(from_.size());
        if (touches == 0) return;
        const stages::SeparationRays out = room_for(touches, scene, directed, edges.chords(), batch,
                                                    routes);
        executor_.for_each(touches, stages::GenerateTouchingRays{out, view_of(from_)});
        keep_inside(scene, out.begin, batch);
    }

    /// Room for more rays at the end of a step's.
    stages::SeparationRays room_for(std::uint32_t count, const Scene& scene,
                                    View<const stages::DirectedPair> directed,
                                    View<const Chord> chords, RayBatch<E>& batch,
                                    Buffer<Route>& routes) {
        const auto begin = static_cast<std::uint32_t>(batch.rays.size());
        batch.resize(begin + count);
        if (scene.plan->remembers()) routes.resize(begin + count);
        return {.bodies = scene.bodies,
                .chords = chords,
                .directed = directed,
                .directions = view_of(directions_),
                .begin = begin,
                .rays = view_of(batch.rays),
                .sources = view_of(batch.sources),
                .hits = view_of(batch.hits),
                .routes = view_of(routes)};
    }

    /// Traces the rays from `begin` on; those that start inside are contacts.
    void keep_inside(const Scene& scene, std::uint32_t begin, RayBatch<E>& batch) {
        const auto count = static_cast<std::uint32_t>(batch.rays.size()) - begin;
        const View<Ray> rays{batch.rays.data() + begin, count};
        const View<Hit> hits{batch.hits.data() + begin, count};
        tools_.update(scene.bodies, count, rays);
        tools_.tracer.closest_hits(executor_, scene.bodies, count, rays, hits);
        executor_.emit(ListId::separated_rays, count,
                       stages::TestInside{.bodies = scene.bodies,
                                          .rays = rays,
                                          .hits = hits,
                                          .routes = {},
                                          .meetings = {batch.meetings.data() + begin, count}},
                       separated_);
        const auto candidates = static_cast<std::uint32_t>(batch.candidates.size());
        const auto added = static_cast<std::uint32_t>(separated_.size());
        batch.candidates.resize(candidates + added);
        batch.keep.resize(candidates + added);
        executor_.for_each(added, stages::KeepSeparated{.inside = view_of(separated_),
                                                        .sources = view_of(batch.sources),
                                                        .meetings = view_of(batch.meetings),
                                                        .first_ray = begin,
                                                        .first_candidate = candidates,
                                                        .candidates = view_of(batch.candidates),
                                                        .keep = view_of(batch.keep),
                                                        .touching = view_of(touching_)});
    }

    /// Chords of pairs without a contact that are more than rounding.
    std::uint32_t list_stranded_chords(const Scene& scene,
                                       View<const stages::DirectedPair> directed,
                                       View<const Chord> chords,
                                       View<const RaySource> from_chords) {
        const std::uint32_t count = tools_.list(
            ListId::stranded_chords, chords.size,
            stages::IsStrandedChord{from_chords, view_of(touching_)}, places_);
        stranded_chords_.clear();
        if (count == 0) return 0;
        part_rays_.resize(2 * std::size_t{count});
        executor_.for_each(count, stages::GenerateStrandedChordRays{.bodies = scene.bodies,
                                                                    .directed = directed,
                                                                    .chords = chords,
                                                                    .stranded = view_of(places_),
                                                                    .sources = from_chords,
                                                                    .rays = view_of(part_rays_)});
        tools_.update(scene.bodies, part_rays_);
        tools_.trace(scene.bodies, part_rays_, part_hits_);
        const std::uint32_t deep = tools_.list(
            ListId::deep_chords, count,
            stages::LeavesBoth{scene.bodies, view_of(part_rays_), view_of(part_hits_)},
            deep_chords_);
        stranded_chords_.resize(deep);
        executor_.for_each(deep,
                           stages::Gather<std::uint32_t>{view_of(places_), view_of(deep_chords_),
                                                         view_of(stranded_chords_)});
        return deep;
    }

    /// Which parts of which bodies are inside the other body of a pair with nothing inside so far.
    void test_parts(const Scene& scene, View<const stages::DirectedPair> directed) {
        counts_.resize(directed.size);
        executor_.for_each(directed.size, stages::CountParts{.bodies = scene.bodies,
                                                             .directed = directed,
                                                             .reached = view_of(reached_),
                                                             .counts = view_of(counts_)});
        const std::uint32_t count = tools_.place(ListId::parts, counts_, offsets_);
        part_rays_.resize(count);
        part_sources_.resize(count);
        executor_.for_each(directed.size,
                           stages::GeneratePartRays{.bodies = scene.bodies,
                                                    .directed = directed,
                                                    .counts = view_of(counts_),
                                                    .offsets = view_of(offsets_),
                                                    .rays = view_of(part_rays_),
                                                    .sources = view_of(part_sources_)});
        inside_tests_ = tools_.list(ListId::asked_parts, count,
                                    stages::IsTraced{view_of(part_rays_)}, contained_);
        contained_.clear();
        if (inside_tests_ == 0) return;
        tools_.update(scene.bodies, part_rays_);
        tools_.trace(scene.bodies, part_rays_, part_hits_);
        tools_.list(ListId::contained_parts, count,
                    stages::LeavesTarget{scene.bodies, view_of(part_rays_), view_of(part_hits_)},
                    contained_);
    }

    StepTools<E, T>& tools_;
    E& executor_;
    Buffer<std::uint32_t> reached_, touching_, deep_, deep_pairs_, counts_, offsets_,
        stranded_vertices_, stranded_chords_, gather_, contained_, places_, deep_chords_,
        separated_;
    Buffer<Ray> part_rays_;
    Buffer<RaySource> part_sources_, from_;
    Buffer<Hit> part_hits_;
    Buffer<Vec3d> directions_;
    std::uint32_t inside_tests_ = 0, deep_count_ = 0;
};

}  // namespace pierce
