#pragma once

#include "pierce/core/scene.hpp"
#include "pierce/core/stages/separation.hpp"
#include "pierce/core/step_tools.hpp"

namespace pierce {

/// Finds pairs that overlap without a contact along an inward ray, and gives them contacts along the direction in which they
/// separate soonest.
template <Executor E, Tracer<E> T>
class Separation {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    explicit Separation(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// Adds the rays of such pairs to `batch` and `routes`, with their hits; returns how many there are.
    std::uint32_t cast(const Scene& scene, View<const Pair> pairs, View<const stages::DirectedPair> directed,
                       View<const Chord> chords, RayBatch<E>& batch, Buffer<Route>& routes) {
        const auto candidates = static_cast<std::uint32_t>(batch.candidates.size());
        const auto all = static_cast<std::uint32_t>(batch.rays.size());
        const View<const RaySource> sources = view_of(std::as_const(batch.sources));
        const View<const RaySource> from_chords{sources.data + (all - chords.size), chords.size};
        executor_.assign(reached_, pairs.size, 0u);
        executor_.assign(touching_, pairs.size, 0u);
        executor_.for_each("mark_touching", candidates,
                           stages::MarkTouching{sources, view_of(batch.candidates), view_of(batch.keep), view_of(reached_),
                                                view_of(touching_)});
        executor_.for_each("mark_reached", chords.size, stages::MarkReached{from_chords, view_of(reached_)});
        test_parts(scene, directed);
        const std::uint32_t vertices = tools_.list(
            "stranded_vertices", candidates,
            stages::IsStrandedVertex{pairs, sources, view_of(batch.candidates), view_of(touching_)}, stranded_vertices_);
        const std::uint32_t stranded =
            vertices + tools_.list("stranded_chords", chords.size, stages::IsStrandedChord{from_chords, view_of(touching_)},
                                   stranded_chords_);
        const auto contained = static_cast<std::uint32_t>(contained_.size());
        deep_count_ = 0;
        if (stranded + contained == 0) return 0;

        // Sources are copied: the list they come from will grow.
        gather_.resize(vertices);
        from_.resize(stranded + contained);
        executor_.for_each(
            "gather_vertices", vertices,
            stages::Gather<std::uint32_t>{view_of(batch.candidates), view_of(stranded_vertices_), view_of(gather_)});
        executor_.for_each("gather_sources", vertices, stages::Gather<RaySource>{sources, view_of(gather_), view_of(from_)});
        executor_.for_each("gather_sources", stranded - vertices,
                           stages::Gather<RaySource>{
                               from_chords, view_of(stranded_chords_), {from_.data() + vertices, stranded - vertices}});
        executor_.for_each(
            "gather_sources", contained,
            stages::Gather<RaySource>{view_of(part_sources_), view_of(contained_), {from_.data() + stranded, contained}});
        executor_.assign(deep_, pairs.size, 0u);
        executor_.for_each("mark_deep", stranded + contained, stages::MarkReached{view_of(from_), view_of(deep_)});
        deep_count_ = tools_.list("deep_list", pairs.size, stages::IsDeep{view_of(deep_)}, deep_pairs_);
        directions_.resize(pairs.size);
        executor_.for_each("find_separation", deep_count_,
                           stages::FindSeparation{scene.bodies, pairs, view_of(deep_pairs_), view_of(directions_)});

        const auto begin = static_cast<std::uint32_t>(batch.rays.size());
        const std::uint32_t added = stranded + contained * stages::GenerateContainedRays::per_part;
        batch.resize(begin + added);
        if (scene.plan->temporal != Temporal::off) routes.resize(begin + added);
        const stages::SeparationRays out{scene.bodies,
                                         chords,
                                         directed,
                                         view_of(directions_),
                                         begin,
                                         view_of(batch.rays),
                                         view_of(batch.sources),
                                         view_of(batch.hits),
                                         view_of(routes)};
        executor_.for_each("generate_stranded_rays", stranded, stages::GenerateStrandedRays{out, view_of(from_)});
        executor_.for_each("generate_contained_rays", contained,
                           stages::GenerateContainedRays{out, {from_.data() + stranded, contained}, stranded});
        tools_.update(scene.bodies, added, {batch.rays.data() + begin, added});
        tools_.tracer.closest_hits(executor_, "trace_separation", scene.bodies, added, {batch.rays.data() + begin, added},
                                   {batch.hits.data() + begin, added});
        return added;
    }

    /// Inside tests of parts that were traced in the last step.
    std::uint32_t inside_tests() const { return inside_tests_; }
    /// Pairs of the last step that overlap without a contact along an inward ray.
    std::uint32_t deep_pairs() const { return deep_count_; }

private:
    /// Which parts of which bodies are inside the other body of a pair with nothing inside so far.
    void test_parts(const Scene& scene, View<const stages::DirectedPair> directed) {
        counts_.resize(directed.size);
        executor_.for_each("count_parts", directed.size,
                           stages::CountParts{scene.bodies, directed, view_of(reached_), view_of(counts_)});
        const std::uint32_t count = tools_.place("part_scan", counts_, offsets_);
        part_rays_.resize(count);
        part_sources_.resize(count);
        executor_.for_each("generate_part_rays", directed.size,
                           stages::GeneratePartRays{scene.bodies, directed, view_of(counts_), view_of(offsets_),
                                                    view_of(part_rays_), view_of(part_sources_)});
        inside_tests_ = tools_.list("parts_asked", count, stages::IsTraced{view_of(part_rays_)}, contained_);
        contained_.clear();
        if (inside_tests_ == 0) return;
        tools_.update(scene.bodies, part_rays_);
        tools_.trace("trace_parts", scene.bodies, part_rays_, part_hits_);
        tools_.list("contained", count, stages::LeavesTarget{scene.bodies, view_of(part_rays_), view_of(part_hits_)},
                    contained_);
    }

    StepTools<E, T>& tools_;
    E& executor_;
    Buffer<std::uint32_t> reached_, touching_, deep_, deep_pairs_, counts_, offsets_, stranded_vertices_, stranded_chords_,
        gather_, contained_;
    Buffer<Ray> part_rays_;
    Buffer<RaySource> part_sources_, from_;
    Buffer<Hit> part_hits_;
    Buffer<Vec3d> directions_;
    std::uint32_t inside_tests_ = 0, deep_count_ = 0;
};

}  // namespace pierce
