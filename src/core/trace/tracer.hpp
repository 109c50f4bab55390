#pragma once

#include <concepts>
#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/trace/ray.hpp"
#include "pierce/body.hpp"

namespace pierce {

/// Work a tracer has done on acceleration structures since it was made, and the tests it needed.
struct TracerCounts {
    std::uint64_t builds = 0;
    std::uint64_t refits = 0;
    std::uint64_t rebuilds = 0;  ///< of trees whose refit had decayed
    std::uint64_t triangle_tests = 0;
};

/// Finds the triangle that each ray crosses first (as CrossingSearch defines it), and the triangle
/// closest to its origin (as ClosestSearch defines it). Must give the same answers as
/// BruteForceTracer for every ray whose origin lies within the target's box, grown by a few touch
/// tolerances.
template <class T, class E>
concept Tracer = requires(T tracer, E executor, View<const BodyView> bodies,
                          View<const std::uint32_t> wanted, typename E::Count count,
                          View<const Ray> rays, View<Hit> hits, View<std::uint32_t> triangles) {
    tracer.update(executor, bodies, wanted);  // make trees of bodies with wanted[body] != 0 fit
                                              // their positions
    tracer.closest_hits(executor, bodies, count, rays, hits);
    // The triangle of its target that is closest to each ray's origin; no_triangle if that triangle
    // is further away than t_max.
    tracer.closest_triangles(executor, bodies, count, rays, triangles);
    tracer.add_up(executor);  // makes counts() tell what was done so far; a stage of a step
    { tracer.counts(executor) } -> std::convertible_to<TracerCounts>;
};

}  // namespace pierce
