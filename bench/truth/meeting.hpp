#pragma once

#include <array>
#include <cstdint>

#include "core/geometry/moving_point.hpp"

namespace pierce::truth {

/// Which two features.
enum class Features : std::uint8_t { vertex_and_face, edges };

/// How questions were decided.
struct MeetingCounts {
    std::uint64_t apart = 0;  ///< a direction that separates them at the start and at the end: they
                              ///< never meet
    std::uint64_t bounded = 0;  ///< signs of polynomials of time, within bounds of rounding
    std::uint64_t ends = 0;     ///< exact predicates on where they are at the start or at the end:
                                ///< they share a point there
    std::uint64_t exact = 0;    ///< rational numbers

    MeetingCounts& operator+=(const MeetingCounts& o) {
        apart += o.apart;
        bounded += o.bounded;
        ends += o.ends;
        exact += o.exact;
        return *this;
    }
};

/// True if a vertex and a face (corners: the vertex, then the face's), or two edges (the ends of
/// one, then of the other), share a point at some time of the step; touching counts. Always right:
/// what doubles cannot decide, exact predicates and rational numbers do. Made of none of the
/// library's detection code.
bool features_meet(Features features, const std::array<MovingPoint, 4>& corners,
                   MeetingCounts* counts = nullptr);

}  // namespace pierce::truth
