#pragma once

#include <cstdint>

#include "core/execute/executor.hpp"
#include "core/step/common/records.hpp"
#include "core/trace/ray.hpp"
#include "pierce/vec3.hpp"

/// The lists of separation in a step, grouped by the part that writes them. They grow and are kept.
namespace pierce {

/// Rays that tell whether something is inside by more than rounding, and what that is.
template <Executor E>
struct InsideTests {
    typename E::template Buffer<Ray> rays;
    typename E::template Buffer<Ray> middles;  ///< where it is asked how deep they run
    typename E::template Buffer<RaySource> sources;
    typename E::template Buffer<Hit> hits;
    typename E::template Buffer<RaySource> inside;
};

/// Pairs that overlap without a contact, and their ways apart.
template <Executor E>
struct WaysApart {
    typename E::template Buffer<std::uint32_t> pairs;
    typename E::template Buffer<Vec3d> directions;  ///< per pair of the step
};

}  // namespace pierce
