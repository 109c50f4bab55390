#pragma once

#include <span>

#include "pierce/mesh.hpp"

namespace pierce::truth {

/// The corners and faces of a convex body.
struct Convex {
    std::span<const Vec3d> positions;
    std::span<const Triangle> triangles;
};

struct Translation {
    double length = 0;
    Vec3d direction;  ///< unit
};

/// The shortest translation of `b` that takes it out of `a`; its length is not positive if they do
/// not overlap. Tries the normal of every face and the cross product of every two edges, which is
/// all that can be shortest. Slow: a few hundred faces each are fine.
Translation minimum_translation(Convex a, Convex b);

}  // namespace pierce::truth
