#pragma once

#include <utility>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/execute/stage_traits.hpp"
#include "core/step/common/gather.hpp"
#include "core/trace/tracer.hpp"
#include "pierce/body.hpp"

namespace pierce {

/// Items to be sorted, and their original order; free again after every use.
template <Executor E>
struct SortScratch {
    typename E::template Buffer<std::uint64_t> keys;
    typename E::template Buffer<std::uint32_t> values, order;
};

/// Executor, tracer and list helpers shared by all parts of a step.
template <Executor E, Tracer<E> T>
class StepTools {
public:
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;
    using Count = typename E::Count;

    StepTools(E& its_executor, T& its_tracer) : executor(its_executor), tracer(its_tracer) {}

    /// Turns per-item counts into places to write to; returns how many there are in all.
    Count place(ListId id, const Buffer<std::uint32_t>& counts, Buffer<std::uint32_t>& offsets) {
        offsets.resize(count_of(counts));
        return executor.exclusive_scan(id, count_of(counts), view_of(counts), view_of(offsets));
    }

    /// Lists the items that are wanted; returns how many there are.
    template <class F>
    Count list(ListId id, Count count, const F& wanted, Buffer<std::uint32_t>& items) {
        items.resize(count);
        const Count found = executor.select(id, count, wanted, view_of(items));
        items.resize(found);
        return found;
    }

    /// Keys and their values, sorted by the lowest `bits` bits of the keys.
    void sort(int bits, Buffer<std::uint64_t>& unsorted_keys, const Buffer<std::uint32_t>& unsorted,
              Buffer<std::uint64_t>& keys, Buffer<std::uint32_t>& values) {
        const Count count = count_of(unsorted_keys);
        keys.resize(count);
        values.resize(count);
        executor.sort(count, bits, view_of(unsorted_keys), view_of(unsorted), view_of(keys),
                      view_of(values));
    }

    /// Runs a stage over groups of sixteen. If there are few groups, each item handles one of the
    /// sixteen.
    template <class Stage>
    void share_out(const Count& groups, const Stage& stage) {
        if (executor.are_few_sixteens(groups))
            stage(OneOfSixteen{}, executor.in_sixteens(groups));
        else
            stage(AllOfSixteen{}, groups);
    }

    /// update on a device, as soon as it is known where bodies are: trees of all bodies, beside the
    /// stages before update(). Refitting all trees ends before it is known which of them are
    /// wanted.
    void update_all(View<const BodyView> bodies) {
        if constexpr (E::traits.overlaps_updates)
            executor.beside([&] {
                wanted_.resize(bodies.size);
                executor.for_each(bodies.size, stages::MarkTargets{bodies, view_of(wanted_)});
                tracer.update(executor, bodies, view_of(std::as_const(wanted_)));
            });
    }

    /// update: Trees of the bodies these rays are aimed at, and of no others.
    void update(View<const BodyView> bodies, const Buffer<Ray>& rays) {
        update(bodies, count_of(rays), view_of(rays));
    }

    void update(View<const BodyView> bodies, Count count, View<const Ray> rays) {
        if constexpr (E::traits.overlaps_updates) return executor.join();
        executor.assign(wanted_, bodies.size, 0u);
        executor.for_each(count, stages::MarkWanted{rays, view_of(wanted_)});
        tracer.update(executor, bodies, view_of(std::as_const(wanted_)));
    }

    /// The triangle each ray crosses first.
    void trace(View<const BodyView> bodies, const Buffer<Ray>& rays, Buffer<Hit>& hits) {
        hits.resize(count_of(rays));
        tracer.closest_hits(executor, bodies, count_of(rays), view_of(rays), view_of(hits));
    }

    /// The same between two stages per ray, which may be NoStage: `before` makes the ray, `after`
    /// reads its hit.
    template <class Before, class After>
    void trace_between(View<const BodyView> bodies, const Buffer<Ray>& rays, Buffer<Hit>& hits,
                       const Before& before, const After& after) {
        const Count count = count_of(rays);
        hits.resize(count);
        if constexpr (E::traits.joins_stages) {
            executor.join();
            tracer.closest_hits(executor, bodies, count, view_of(rays), view_of(hits), before,
                                after);
        } else {
            if constexpr (!is_no_stage<Before>) executor.for_each(count, before);
            update(bodies, rays);
            tracer.closest_hits(executor, bodies, count, view_of(rays), view_of(hits));
            if constexpr (!is_no_stage<After>) executor.for_each(count, after);
        }
    }

    /// The triangle closest to each ray's origin, t_max away at most; holds until the next call.
    View<const std::uint32_t> closest(View<const BodyView> bodies, const Buffer<Ray>& rays) {
        closest_.resize(count_of(rays));
        tracer.closest_triangles(executor, bodies, count_of(rays), view_of(rays),
                                 view_of(closest_));
        return view_of(std::as_const(closest_));
    }

    /// The same between two stages per ray; `after` is made with the list of these triangles.
    template <class Before, class MakeAfter>
    void closest_between(View<const BodyView> bodies, const Buffer<Ray>& rays, const Before& before,
                         const MakeAfter& after) {
        const Count count = count_of(rays);
        closest_.resize(count);
        if constexpr (E::traits.joins_stages) {
            executor.join();
            tracer.closest_triangles(executor, bodies, count, view_of(rays), view_of(closest_),
                                     before, after(view_of(std::as_const(closest_))));
        } else {
            executor.for_each(count, before);
            update(bodies, rays);
            executor.for_each(count, after(closest(bodies, rays)));
        }
    }

    E& executor;
    T& tracer;

private:
    Buffer<std::uint32_t> wanted_, closest_;
};

}  // namespace pierce
