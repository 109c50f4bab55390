#pragma once

#include <optional>
#include <span>

#include "pierce/vec3.hpp"

namespace pierce {

/// The points x with normal . x >= least.
struct HalfSpace {
    Vec3d normal;  ///< unit
    double least = 0;
};

/// The point closest to the origin that is in all half-spaces, up to
/// constants::translation_rounding of how far the furthest half-space is; nothing if there is none,
/// or if rounding hides it. The half-space that is missed most joins those that hold the point,
/// three at most, until none is missed: each time the point gets further from the origin (the dual
/// active-set method of Goldfarb and Idnani 1983, for three unknowns).
std::optional<Vec3d> closest_to_origin(std::span<const HalfSpace> all);

}  // namespace pierce
