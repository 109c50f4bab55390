#pragma once

#include <cstdint>
#include <utility>

#include "core/device/view.hpp"
#include "core/step/common/step_tools.hpp"
#include "core/step/solids/mark_candidate.hpp"
#include "core/step/solids/ray_batch.hpp"
#include "core/step/solids/reproject.hpp"
#include "core/step/solids/step_of_pairs.hpp"

namespace pierce {

/// Decides how deep candidates are: contacts move to the closest point of their target's surface,
/// if the plan asks for that, and pairs are told what they have.
template <Executor E, Tracer<E> T>
class Reprojection {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;
    using Count = typename E::Count;

    explicit Reprojection(StepTools<E, T>& tools) : tools_(tools) {}

    /// Takes the `count` candidates of `batch` from the `begin`-th on. Earlier ones stay as they
    /// are. `routes` of all rays of `batch`; empty if steps do not remember.
    void decide(const StepOfPairs<E>& step, RayBatch<E>& batch, const Count& begin,
                const Count& count, View<const Chord> chords, View<std::uint32_t> flat,
                View<const Route> routes) {
        const Plan& plan = *step.scene.plan;
        const stages::ContainedBodies contained{
            .bodies = step.scene.bodies,
            .pairs = step.pairs,
            .marks = step.marks,
            .are_asked_for = plan.misses_no_overlap() && plan.settings.inside_is_contact()};
        if (plan.reprojects) move(step, batch, begin, count, chords, routes, contained);
        tools_.executor.for_each(count,
                                 stages::MarkCandidate{.sources = view_of(batch.sources),
                                                       .rays = view_of(batch.rays),
                                                       .meetings = view_of(batch.meetings),
                                                       .candidates = view_of(batch.candidates),
                                                       .keep = view_of(batch.keep),
                                                       .moved_rays = view_of(aimed_.rays),
                                                       .moved = view_of(aimed_.meetings),
                                                       .accepted = view_of(accepted_),
                                                       .contained = contained,
                                                       .begin = begin,
                                                       .marks = step.marks,
                                                       .flat = flat});
    }

    /// The contacts that have moved: per candidate, whether it has, and of how many candidates that
    /// is known.
    stages::RayResults moved() const { return aimed_.results(); }
    View<const std::uint32_t> accepted() const { return view_of(accepted_); }
    Count decided() const { return count_of(accepted_); }

    void clear() {
        aimed_.clear();
        accepted_.clear();
    }

private:
    void move(const StepOfPairs<E>& step, const RayBatch<E>& batch, const Count& begin,
              const Count& count, View<const Chord> chords, View<const Route> routes,
              const stages::ContainedBodies& contained) {
        const View<const BodyView> bodies = step.scene.bodies;
        aimed_.rays.resize(begin + count);
        aimed_.hits.resize(begin + count);
        aimed_.meetings.resize(begin + count);
        accepted_.resize(begin + count);
        limited_.resize(count);
        known_.resize(count);
        tools_.closest_between(bodies, limited_,
                               stages::LimitToDepth{.bodies = bodies,
                                                    .rays = view_of(batch.rays),
                                                    .sources = view_of(batch.sources),
                                                    .hits = view_of(batch.hits),
                                                    .meetings = view_of(batch.meetings),
                                                    .routes = routes,
                                                    .candidates = view_of(batch.candidates),
                                                    .keep = view_of(batch.keep),
                                                    .begin = begin,
                                                    .limited = view_of(limited_),
                                                    .known = view_of(known_),
                                                    .pairs = step.pairs,
                                                    .chords = chords,
                                                    .all = step.scene.plan->settings.reproject},
                               [&](View<const std::uint32_t> closest) {
                                   return stages::MoveToClosest{
                                       .bodies = bodies,
                                       .limited = view_of(std::as_const(limited_)),
                                       .known = view_of(std::as_const(known_)),
                                       .closest = closest,
                                       .sources = view_of(batch.sources),
                                       .chords = chords,
                                       .candidates = view_of(batch.candidates),
                                       .found = view_of(batch.meetings),
                                       .begin = begin,
                                       .rays = view_of(aimed_.rays),
                                       .hits = view_of(aimed_.hits),
                                       .meetings = view_of(aimed_.meetings),
                                       .accepted = view_of(accepted_),
                                       .contained = contained};
                               });
    }

    StepTools<E, T>& tools_;
    RayBatch<E> aimed_;
    Buffer<std::uint32_t> accepted_;
    Buffer<Ray> limited_;
    Buffer<std::uint32_t> known_;
};

}  // namespace pierce
