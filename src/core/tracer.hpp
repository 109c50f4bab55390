#pragma once

#include <concepts>
#include <cstdint>

#include "pierce/core/body.hpp"
#include "pierce/core/executor.hpp"
#include "pierce/core/ray.hpp"

namespace pierce {

/// Work a tracer has done on acceleration structures since it was made, and the tests it needed.
struct TracerCounts {
    std::uint64_t builds = 0;
    std::uint64_t refits = 0;
    std::uint64_t rebuilds = 0;  ///< of trees whose refit had decayed
    std::uint64_t triangle_tests = 0;
};

/// Finds the triangle each ray crosses first (the meaning is CrossingSearch's). Must give the same answer as
/// BruteForceTracer for every ray whose origin lies within the target's box, grown by a few touch tolerances.
template <class T, class E>
concept Tracer = requires(T tracer, E executor, View<const BodyView> bodies, View<const std::uint32_t> wanted,
                          View<const Ray> rays, View<Hit> hits) {
    tracer.update(executor, bodies, wanted);  // make trees of bodies with wanted[body] != 0 fit their positions
    tracer.closest_hits(executor, "trace", bodies, rays, hits);
    { tracer.counts() } -> std::convertible_to<TracerCounts>;
};

}  // namespace pierce
