#pragma once

#include <cstdint>

#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/ray.hpp"

namespace pierce::stages {

/// Rays and what became of them.
struct RayResults {
    View<const Ray> rays;
    View<const Hit> hits;
    View<const Meeting> meetings;
};

}  // namespace pierce::stages

namespace pierce {

/// Rays on their way through a step, side by side: what they are, what they met, and which of them
/// are contacts.
template <Executor E>
struct RayBatch {
    template <class Item>
    using Buffer = typename E::template Buffer<Item>;

    Buffer<Ray> rays;
    Buffer<RaySource> sources;
    Buffer<Hit> hits;
    Buffer<Meeting> meetings;
    Buffer<std::uint32_t> candidates;  ///< rays that started inside their target
    Buffer<std::uint32_t> keep;        ///< per candidate: 1 for a contact

    void resize(const typename E::Count& count) {
        rays.resize(count);
        sources.resize(count);
        hits.resize(count);
        meetings.resize(count);
    }

    void clear() {
        resize(0u);
        candidates.clear();
        keep.clear();
    }

    stages::RayResults results() const { return {view_of(rays), view_of(hits), view_of(meetings)}; }
};

}  // namespace pierce
