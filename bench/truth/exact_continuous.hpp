#pragma once

#include <gmpxx.h>

#include <array>
#include <optional>

#include "core/geometry/moving_point.hpp"

namespace pierce::truth {

/// A point with rational coordinates that moves in a straight line from time 0 to time 1.
struct ExactMovingPoint {
    std::array<mpq_class, 3> start, end;
};

/// Four of them: a vertex and three corners, or the ends of one edge and of another.
using ExactCorners = std::array<ExactMovingPoint, 4>;

ExactCorners exact(const std::array<MovingPoint, 4>& corners);

/// A time between two rationals that are closer than 2^-64.
struct ExactTime {
    mpq_class lower, upper;
};

/// When a moving vertex first meets a moving face, decided without rounding; nothing if it does not
/// up to time 1. The face may lack area, and all may stay in one plane.
std::optional<ExactTime> first_meeting_of_vertex_and_face(const ExactCorners& corners);

/// When two moving edges first meet, likewise. They may be parallel, or points.
std::optional<ExactTime> first_meeting_of_edges(const ExactCorners& corners);

}  // namespace pierce::truth
