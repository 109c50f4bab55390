#pragma once

#include <cstdint>

#include "core/execute/executor.hpp"
#include "core/step/common/records.hpp"
#include "core/trace/ray.hpp"
#include "pierce/vec3.hpp"

/// The lists of separation in a step, grouped by the part that writes them. They grow and are kept.
namespace pierce {

/// Per pair: what is known of it.
template <Executor E>
struct PairMarks {
    typename E::template Buffer<std::uint32_t> reached, touching, has_depth, deep;
    typename E::template Buffer<std::uint32_t> flat;  ///< per chord
};

/// Parts of bodies that are looked for inside the other body. Their rays also test chords.
template <Executor E>
struct PartLists {
    typename E::template Buffer<std::uint32_t> counts, offsets, contained;
    typename E::template Buffer<Ray> rays;
    typename E::template Buffer<RaySource> sources;
    typename E::template Buffer<Hit> hits;
};

/// What is inside a body whose pair has no contact, and the way apart.
template <Executor E>
struct StrandedLists {
    typename E::template Buffer<std::uint32_t> vertices, chords, deep_chords, deep_pairs, gather,
        places, separated;
    typename E::template Buffer<RaySource> of_chords, from;
    typename E::template Buffer<Vec3d> directions;
};

}  // namespace pierce
