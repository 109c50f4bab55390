#pragma once

#include <cstdint>

#include "core/device/number.hpp"
#include "core/device/view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/ray_batch.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/ray.hpp"

namespace pierce {

namespace stages {

/// Where rays that start inside their target join a batch after its own rays are classified: as
/// rays and as candidates.
struct JoinBatch {
    View<const Ray> from_rays;
    View<const RaySource> from_sources;
    View<const Hit> from_hits;
    View<const Meeting> from_meetings;
    Number first_ray, first_candidate;  ///< how many the batch has already
    View<Ray> rays;
    View<RaySource> sources;
    View<Hit> hits;
    View<Meeting> meetings;
    View<Route> routes;  ///< empty if steps do not remember
    View<std::uint32_t> candidates, keep;

    /// Ray `from` joins as the i-th one; returns which candidate it is.
    PIERCE_HD std::uint32_t join(std::uint32_t i, std::uint32_t from, bool is_contact) const {
        return put(i, from_rays[from], from_sources[from], from_hits[from], from_meetings[from],
                   is_contact);
    }

    /// The same for any ray.
    PIERCE_HD std::uint32_t put(std::uint32_t i, const Ray& its_ray, const RaySource& source,
                                const Hit& hit, const Meeting& meeting, bool is_contact) const {
        const std::uint32_t ray = first_ray + i, candidate = first_candidate + i;
        rays[ray] = its_ray;
        sources[ray] = source;
        hits[ray] = hit;
        meetings[ray] = meeting;
        if (routes.size > 0) routes[ray] = Route::full;
        candidates[candidate] = ray;
        keep[candidate] = is_contact;
        return candidate;
    }
};

}  // namespace stages

/// Makes room in `batch` and, if steps remember, in `routes` for `count` rays of `from` that are
/// candidates.
template <Executor E>
stages::JoinBatch room_in(RayBatch<E>& batch, typename E::template Buffer<Route>& routes,
                          bool remembers, const typename E::Count& count, const RayBatch<E>& from) {
    const typename E::Count rays = count_of(batch.rays), candidates = count_of(batch.candidates);
    batch.resize(rays + count);
    if (remembers) routes.resize(rays + count);
    batch.candidates.resize(candidates + count);
    batch.keep.resize(candidates + count);
    return {.from_rays = view_of(from.rays),
            .from_sources = view_of(from.sources),
            .from_hits = view_of(from.hits),
            .from_meetings = view_of(from.meetings),
            .first_ray = rays,
            .first_candidate = candidates,
            .rays = view_of(batch.rays),
            .sources = view_of(batch.sources),
            .hits = view_of(batch.hits),
            .meetings = view_of(batch.meetings),
            .routes = view_of(routes),
            .candidates = view_of(batch.candidates),
            .keep = view_of(batch.keep)};
}

}  // namespace pierce
