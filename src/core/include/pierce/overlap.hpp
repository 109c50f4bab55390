#pragma once

#include <vector>

#include "pierce/vec3.hpp"

namespace pierce {

/// Places where two bodies overlap along nearly the same direction. Of both bodies' surfaces, half
/// of what is inside the other one counts. World space.
struct ContactPatch {
    double area = 0;          ///< [length^2]
    double depth_volume = 0;  ///< [length^3] the integral of the depth over the area; the depth of
                              ///< a place is its distance to the other surface
    Vec3d center;             ///< the middle of the area
    Vec3d normal;             ///< unit, from a to b: the mean over the area
    double depth = 0;  ///< [length] of the deepest place that was looked at, such as a vertex
    Vec3d deepest;     ///< where that is
};

/// What two solids have in common where they are. A place that a body covers several times counts
/// as often. World space.
struct Overlap {
    double volume = 0;  ///< [length^3]
    Vec3d center;       ///< the middle of the volume
    double area_a = 0;  ///< [length^2] of a's surface inside b
    double area_b = 0;  ///< [length^2] of b's surface inside a
    /// [length^2] the integral of the outward normal over a's surface inside b; that over b's
    /// inside a is its opposite. It points from a to b. When b moves by a short way, the volume
    /// shrinks by the way's dot product with it.
    Vec3d push;
    /// [length^3] the same for turns about `center`: the integral of place x normal.
    Vec3d turn;
    std::vector<ContactPatch> patches;  ///< the deepest first
};

}  // namespace pierce
