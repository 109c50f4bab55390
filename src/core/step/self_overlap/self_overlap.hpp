#pragma once

#include <utility>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/gather.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/self_overlap/self_overlap_stages.hpp"
#include "core/step/solids/ray_batch.hpp"

namespace pierce {

/// Decides which rays of solids into themselves are contacts.
template <Executor E, Tracer<E> T>
class SelfOverlap {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;
    using Count = typename E::Count;

    explicit SelfOverlap(StepTools<E, T>& tools) : tools_(tools), executor_(tools.executor) {}

    /// Clears `batch.keep` of candidates that are not inside another part of their own body.
    void test(const Scene& scene, View<const Pair> pairs, RayBatch<E>& batch) {
        const Count count = tools_.list(
            ListId::self_candidates, count_of(batch.candidates),
            stages::IsSelfCandidate{.bodies = scene.bodies,
                                    .pairs = pairs,
                                    .sources = view_of(batch.sources),
                                    .candidates = view_of(batch.candidates)},
            listed_);
        outward_.resize(count);
        winding_.resize(count);
        active_.resize(count);
        executor_.for_each(count,
                           stages::GenerateOutwardRays{.bodies = scene.bodies,
                                                       .rays = view_of(batch.rays),
                                                       .candidates = view_of(batch.candidates),
                                                       .listed = view_of(listed_),
                                                       .outward = view_of(outward_),
                                                       .winding = view_of(winding_),
                                                       .active = view_of(active_)});
        tools_.update(scene.bodies, outward_);
        executor_.repeat(
            ListId::outward_rays, [&] { return count_of(active_); },
            [&] { follow_outward(scene); });
        find_exits(scene, batch, count);
        executor_.for_each(count, stages::KeepSelf{.bodies = scene.bodies,
                                                   .rays = view_of(batch.rays),
                                                   .sources = view_of(batch.sources),
                                                   .hits = view_of(batch.hits),
                                                   .meetings = view_of(batch.meetings),
                                                   .candidates = view_of(batch.candidates),
                                                   .listed = view_of(listed_),
                                                   .winding = view_of(winding_),
                                                   .keep = view_of(batch.keep)});
    }

private:
    /// Follows every outward ray that still goes on by one crossing.
    void follow_outward(const Scene& scene) {
        trace_active(scene, outward_);
        executor_.for_each(count_of(active_), stages::AdvanceOutward{.bodies = scene.bodies,
                                                                     .hits = view_of(now_hits_),
                                                                     .active = view_of(active_),
                                                                     .outward = view_of(outward_),
                                                                     .winding = view_of(winding_),
                                                                     .goes_on = view_of(goes_on_)});
        keep_active(ListId::outward_rays);
    }

    /// Of `count` candidates: follows the inward rays that enter other parts first to their exits.
    void find_exits(const Scene& scene, RayBatch<E>& batch, const Count& count) {
        const Count entering = tools_.list(
            ListId::entering_rays, count,
            stages::EntersFirst{view_of(batch.meetings), view_of(batch.candidates),
                                view_of(listed_)},
            active_);
        inward_.resize(count);
        entered_.resize(count);
        executor_.for_each(entering, stages::GoOnInward{.rays = view_of(batch.rays),
                                                        .meetings = view_of(batch.meetings),
                                                        .candidates = view_of(batch.candidates),
                                                        .listed = view_of(listed_),
                                                        .active = view_of(active_),
                                                        .inward = view_of(inward_),
                                                        .entered = view_of(entered_)});
        executor_.repeat(
            ListId::inward_rays, [&] { return count_of(active_); },
            [&] { follow_inward(scene, batch); });
    }

    /// Follows every inward ray that still goes on by one crossing.
    void follow_inward(const Scene& scene, RayBatch<E>& batch) {
        trace_active(scene, inward_);
        executor_.for_each(count_of(active_),
                           stages::AdvanceInward{.bodies = scene.bodies,
                                                 .found = view_of(now_hits_),
                                                 .candidates = view_of(batch.candidates),
                                                 .listed = view_of(listed_),
                                                 .active = view_of(active_),
                                                 .inward = view_of(inward_),
                                                 .entered = view_of(entered_),
                                                 .hits = view_of(batch.hits),
                                                 .meetings = view_of(batch.meetings),
                                                 .goes_on = view_of(goes_on_)});
        keep_active(ListId::inward_rays);
    }

    /// Traces those of `rays` that are active.
    void trace_active(const Scene& scene, Buffer<Ray>& rays) {
        const Count count = count_of(active_);
        now_rays_.resize(count);
        goes_on_.resize(count);
        executor_.for_each(
            count, stages::Gather<Ray>{view_of(rays), view_of(active_), view_of(now_rays_)});
        tools_.trace(scene.bodies, now_rays_, now_hits_);
    }

    /// Makes those that go on the active ones.
    void keep_active(ListId list) {
        const Count left = tools_.list(list, count_of(active_), stages::IsMarked{view_of(goes_on_)},
                                       places_);
        next_active_.resize(left);
        executor_.for_each(left, stages::Gather<std::uint32_t>{view_of(active_), view_of(places_),
                                                               view_of(next_active_)});
        std::swap(active_, next_active_);
    }

    StepTools<E, T>& tools_;
    E& executor_;
    Buffer<std::uint32_t> listed_, active_, next_active_, places_, goes_on_;
    Buffer<Ray> outward_, inward_, now_rays_;
    Buffer<Hit> now_hits_;
    Buffer<std::int32_t> winding_, entered_;
};

}  // namespace pierce
