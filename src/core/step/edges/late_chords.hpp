#pragma once

#include <cstdint>
#include <utility>

#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/pairs.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/ray_batch.hpp"

namespace pierce::stages {

/// Per candidate among some rays of a batch: appends it to the batch's candidates.
struct AppendCandidate {
    View<const std::uint32_t> found, found_keep;
    std::uint32_t first_ray = 0, first_candidate = 0;
    View<std::uint32_t> candidates, keep;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        candidates[first_candidate + i] = first_ray + found[i];
        keep[first_candidate + i] = found_keep[i];
    }
};

}  // namespace pierce::stages

namespace pierce {

/// Takes rays that join a batch after its rays are classified, those of chords in pairs without a
/// contact, through trace and classify.
template <Executor E, Tracer<E> T>
class LateChords {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    explicit LateChords(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// Appends to the batch's candidates those of its last `count` rays that start inside.
    void classify(const Scene& scene, View<const Pair> pairs, View<const Chord> chords,
                  std::uint32_t count, RayBatch<E>& batch) {
        if (count == 0) return;
        const auto begin = static_cast<std::uint32_t>(batch.rays.size()) - count;
        const View<Ray> rays{batch.rays.data() + begin, count};
        const View<Hit> hits{batch.hits.data() + begin, count};
        const View<Meeting> meetings{batch.meetings.data() + begin, count};
        tools_.update(scene.bodies, count, rays);
        tools_.tracer.closest_hits(executor_, scene.bodies, count, rays, hits);
        executor_.emit(ListId::candidates, count,
                       stages::GenerateOwnRays{.inside_target = {.bodies = scene.bodies,
                                                                 .rays = rays,
                                                                 .hits = hits,
                                                                 .routes = {},
                                                                 .meetings = meetings},
                                               .pairs = pairs,
                                               .chords = chords,
                                               .sources = {batch.sources.data() + begin, count}},
                       candidates_, own_rays_, starts_inside_);
        const auto found = static_cast<std::uint32_t>(candidates_.size()),
                   before = static_cast<std::uint32_t>(batch.candidates.size());
        if (found == 0) return;
        tools_.update(scene.bodies, own_rays_);
        tools_.trace(scene.bodies, own_rays_, own_hits_);
        keep_.resize(found);
        executor_.for_each(
            found, stages::TestOwnExit{.bodies = scene.bodies,
                                       .rays = rays,
                                       .meetings = meetings,
                                       .candidates = view_of(std::as_const(candidates_)),
                                       .own_rays = view_of(std::as_const(own_rays_)),
                                       .own_hits = view_of(std::as_const(own_hits_)),
                                       .starts_inside = view_of(std::as_const(starts_inside_)),
                                       .keep = view_of(keep_)});
        batch.candidates.resize(before + found);
        batch.keep.resize(before + found);
        executor_.for_each(found,
                           stages::AppendCandidate{.found = view_of(std::as_const(candidates_)),
                                                   .found_keep = view_of(std::as_const(keep_)),
                                                   .first_ray = begin,
                                                   .first_candidate = before,
                                                   .candidates = view_of(batch.candidates),
                                                   .keep = view_of(batch.keep)});
    }

private:
    StepTools<E, T>& tools_;
    E& executor_;
    Buffer<std::uint32_t> candidates_, keep_, starts_inside_;
    Buffer<Ray> own_rays_;
    Buffer<Hit> own_hits_;
};

}  // namespace pierce
