#pragma once

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/edges/edge_chords.hpp"
#include "core/step/edges/late_chords.hpp"
#include "core/step/separation/separation_lists.hpp"
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

    explicit Separation(StepTools<E, T>& tools)
        : tools_(tools), executor_(tools.executor), late_chords_(tools) {}

    /// Adds the rays of such pairs to `batch` and `routes`; rays that start inside become
    /// candidates that are contacts. Earlier candidates stay candidates.
    void separate(const Scene& scene, View<const Pair> pairs,
                  View<const stages::DirectedPair> directed, View<const PairMemory> memory,
                  View<const std::uint32_t> links, EdgeChords<E, T>& edges, RayBatch<E>& batch,
                  Buffer<Route>& routes) {
        mark(pairs, directed, edges, batch);
        late_rays_ = 0;
        if (!scene.plan->is_complete()) {
            edges.find(scene, directed, memory, links, view_of(marks_.has_depth), batch, routes);
            late_rays_ = edges.chords().size;
            late_chords_.classify(scene, pairs, edges.chords(), late_rays_, batch);
            mark(pairs, directed, edges, batch);
        }
        list_chords(scene, directed, edges, batch);
        add_stranded(scene, pairs, directed, edges, batch, routes);
        add_touching(scene, directed, edges, batch, routes);
    }

    /// How many rays were traced after all others in the last step, of chords in pairs that had no
    /// contact.
    std::uint32_t late_rays() const { return late_rays_; }
    /// How many inside tests of parts were traced in the last step.
    std::uint32_t inside_tests() const { return inside_tests_; }
    /// How many pairs of the last step overlap without a contact along an inward ray.
    std::uint32_t deep_pairs() const { return deep_count_; }

private:
    /// Which pairs have something inside so far, a contact, a contact with a depth.
    void mark(View<const Pair> pairs, View<const stages::DirectedPair> directed,
              const EdgeChords<E, T>& edges, RayBatch<E>& batch) {
        executor_.assign(marks_.reached, pairs.size, 0u);
        executor_.assign(marks_.touching, pairs.size, 0u);
        executor_.assign(marks_.has_depth, pairs.size, 0u);
        executor_.assign(marks_.flat, edges.chords().size, no_record);
        executor_.for_each(static_cast<std::uint32_t>(batch.candidates.size()),
                           stages::MarkTouching{.sources = view_of(std::as_const(batch.sources)),
                                                .meetings = view_of(std::as_const(batch.meetings)),
                                                .candidates = view_of(batch.candidates),
                                                .keep = view_of(batch.keep),
                                                .reached = view_of(marks_.reached),
                                                .touching = view_of(marks_.touching),
                                                .has_depth = view_of(marks_.has_depth),
                                                .flat = view_of(marks_.flat)});
        executor_.for_each(pairs.size, stages::MarkStill{.directed = directed,
                                                         .reached = view_of(marks_.reached),
                                                         .touching = view_of(marks_.touching),
                                                         .has_depth = view_of(marks_.has_depth)});
    }

    /// Adds rays along the way apart, from vertices and chords that are inside but whose pair has
    /// no contact, and from parts of bodies that are inside.
    void add_stranded(const Scene& scene, View<const Pair> pairs,
                      View<const stages::DirectedPair> directed, const EdgeChords<E, T>& edges,
                      RayBatch<E>& batch, Buffer<Route>& routes) {
        const auto candidates = static_cast<std::uint32_t>(batch.candidates.size());
        const View<const RaySource> sources = view_of(std::as_const(batch.sources));
        const View<const Chord> chords = edges.chords();
        const View<const RaySource> from_chords = view_of(std::as_const(stranded_.of_chords));
        executor_.for_each(chords.size, stages::MarkReached{from_chords, view_of(marks_.reached)});
        test_parts(scene, directed);
        const std::uint32_t stranded_chords = list_stranded_chords(scene, directed, chords,
                                                                   from_chords);
        const std::uint32_t vertices = tools_.list(
            ListId::stranded_vertices, candidates,
            stages::IsStrandedVertex{.pairs = pairs,
                                     .sources = sources,
                                     .candidates = view_of(batch.candidates),
                                     .touching = view_of(marks_.touching)},
            stranded_.vertices);
        const std::uint32_t stranded = vertices + stranded_chords;
        const auto contained = static_cast<std::uint32_t>(parts_.contained.size());
        deep_count_ = 0;
        if (stranded + contained == 0) return;

        // Sources are copied: the list they come from will grow.
        stranded_.gather.resize(vertices);
        stranded_.from.resize(stranded + contained);
        executor_.for_each(vertices, stages::Gather<std::uint32_t>{view_of(batch.candidates),
                                                                   view_of(stranded_.vertices),
                                                                   view_of(stranded_.gather)});
        executor_.for_each(vertices, stages::Gather<RaySource>{sources, view_of(stranded_.gather),
                                                               view_of(stranded_.from)});
        executor_.for_each(
            stranded - vertices,
            stages::Gather<RaySource>{from_chords,
                                      view_of(stranded_.chords),
                                      {stranded_.from.data() + vertices, stranded - vertices}});
        executor_.for_each(
            contained, stages::Gather<RaySource>{view_of(parts_.sources),
                                                 view_of(parts_.contained),
                                                 {stranded_.from.data() + stranded, contained}});
        executor_.assign(marks_.deep, pairs.size, 0u);
        executor_.for_each(stranded + contained,
                           stages::MarkReached{view_of(stranded_.from), view_of(marks_.deep)});
        deep_count_ = tools_.list(ListId::deep_pairs, pairs.size,
                                  stages::IsDeep{view_of(marks_.deep)}, stranded_.deep_pairs);
        stranded_.directions.resize(pairs.size);
        executor_.for_each(deep_count_,
                           stages::FindSeparation{.bodies = scene.bodies,
                                                  .pairs = pairs,
                                                  .deep_pairs = view_of(stranded_.deep_pairs),
                                                  .directions = view_of(stranded_.directions)});

        const std::uint32_t added = stranded + contained * stages::GenerateContainedRays::per_part;
        const stages::SeparationRays out = room_for(added, scene, directed, chords, batch, routes);
        executor_.for_each(stranded, stages::GenerateStrandedRays{out, view_of(stranded_.from)});
        executor_.for_each(contained,
                           stages::GenerateContainedRays{
                               out, {stranded_.from.data() + stranded, contained}, stranded});
        keep_inside(scene, out.begin, batch);
    }

    /// Adds rays from edges that lie in the other body's surface, or only touch it.
    void add_touching(const Scene& scene, View<const stages::DirectedPair> directed,
                      EdgeChords<E, T>& edges, RayBatch<E>& batch, Buffer<Route>& routes) {
        edges.add_touching_chords(scene, directed, view_of(marks_.touching), stranded_.from);
        const auto touches = static_cast<std::uint32_t>(stranded_.from.size());
        if (touches == 0) return;
        const stages::SeparationRays out = room_for(touches, scene, directed, edges.chords(), batch,
                                                    routes);
        executor_.for_each(touches, stages::GenerateTouchingRays{out, view_of(stranded_.from)});
        keep_inside(scene, out.begin, batch);
    }

    /// Makes room for more rays at the end of a step's rays.
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
                .directions = view_of(stranded_.directions),
                .begin = begin,
                .rays = view_of(batch.rays),
                .sources = view_of(batch.sources),
                .hits = view_of(batch.hits),
                .routes = view_of(routes)};
    }

    /// Traces the rays from `begin` on; rays that start inside are contacts.
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
                       stranded_.separated);
        const auto candidates = static_cast<std::uint32_t>(batch.candidates.size());
        const auto added = static_cast<std::uint32_t>(stranded_.separated.size());
        batch.candidates.resize(candidates + added);
        batch.keep.resize(candidates + added);
        executor_.for_each(added,
                           stages::KeepSeparated{.inside = view_of(stranded_.separated),
                                                 .sources = view_of(batch.sources),
                                                 .meetings = view_of(batch.meetings),
                                                 .first_ray = begin,
                                                 .first_candidate = candidates,
                                                 .candidates = view_of(batch.candidates),
                                                 .keep = view_of(batch.keep),
                                                 .touching = view_of(marks_.touching),
                                                 .flat = view_of(std::as_const(marks_.flat))});
    }

    /// Lists where chords come from: those with rays of their own, which are the last of the batch,
    /// and those that count only in pairs without a contact.
    void list_chords(const Scene& scene, View<const stages::DirectedPair> directed,
                     EdgeChords<E, T>& edges, const RayBatch<E>& batch) {
        const std::uint32_t count = edges.chords().size;
        const auto all = static_cast<std::uint32_t>(batch.sources.size());
        stranded_.of_chords.resize(count);
        executor_.for_each(count,
                           stages::Copy<RaySource>{{batch.sources.data() + (all - count), count},
                                                   view_of(stranded_.of_chords)});
        edges.add_chords_at_ends(scene, directed, view_of(marks_.has_depth), stranded_.of_chords);
    }

    /// Lists the chords that are inside by more than rounding, of pairs without a contact.
    std::uint32_t list_stranded_chords(const Scene& scene,
                                       View<const stages::DirectedPair> directed,
                                       View<const Chord> chords,
                                       View<const RaySource> from_chords) {
        const std::uint32_t count = tools_.list(
            ListId::stranded_chords, chords.size,
            stages::IsStrandedChord{from_chords, view_of(marks_.has_depth)}, stranded_.places);
        stranded_.chords.clear();
        if (count == 0) return 0;
        parts_.rays.resize(2 * std::size_t{count});
        executor_.for_each(count,
                           stages::GenerateStrandedChordRays{.bodies = scene.bodies,
                                                             .directed = directed,
                                                             .chords = chords,
                                                             .stranded = view_of(stranded_.places),
                                                             .sources = from_chords,
                                                             .rays = view_of(parts_.rays)});
        tools_.update(scene.bodies, parts_.rays);
        tools_.trace(scene.bodies, parts_.rays, parts_.hits);
        const std::uint32_t deep = tools_.list(
            ListId::deep_chords, count,
            stages::LeavesBoth{scene.bodies, view_of(parts_.rays), view_of(parts_.hits)},
            stranded_.deep_chords);
        stranded_.chords.resize(deep);
        executor_.for_each(deep, stages::Gather<std::uint32_t>{view_of(stranded_.places),
                                                               view_of(stranded_.deep_chords),
                                                               view_of(stranded_.chords)});
        return deep;
    }

    /// Finds which parts of bodies are inside the other body, for pairs with nothing inside so far.
    void test_parts(const Scene& scene, View<const stages::DirectedPair> directed) {
        parts_.counts.resize(directed.size);
        executor_.for_each(directed.size, stages::CountParts{.bodies = scene.bodies,
                                                             .directed = directed,
                                                             .reached = view_of(marks_.reached),
                                                             .counts = view_of(parts_.counts)});
        const std::uint32_t count = tools_.place(ListId::parts, parts_.counts, parts_.offsets);
        parts_.rays.resize(count);
        parts_.sources.resize(count);
        executor_.for_each(directed.size,
                           stages::GeneratePartRays{.bodies = scene.bodies,
                                                    .directed = directed,
                                                    .counts = view_of(parts_.counts),
                                                    .offsets = view_of(parts_.offsets),
                                                    .rays = view_of(parts_.rays),
                                                    .sources = view_of(parts_.sources)});
        inside_tests_ = tools_.list(ListId::asked_parts, count,
                                    stages::IsTraced{view_of(parts_.rays)}, parts_.contained);
        parts_.contained.clear();
        if (inside_tests_ == 0) return;
        tools_.update(scene.bodies, parts_.rays);
        tools_.trace(scene.bodies, parts_.rays, parts_.hits);
        tools_.list(ListId::contained_parts, count,
                    stages::LeavesTarget{scene.bodies, view_of(parts_.rays), view_of(parts_.hits)},
                    parts_.contained);
    }

    StepTools<E, T>& tools_;
    E& executor_;
    LateChords<E, T> late_chords_;
    PairMarks<E> marks_;
    PartLists<E> parts_;
    StrandedLists<E> stranded_;
    std::uint32_t late_rays_ = 0, inside_tests_ = 0, deep_count_ = 0;
};

}  // namespace pierce
