#pragma once

#include "pierce/vec3.hpp"

namespace pierce {

/// A point that moves in a straight line during the step, from time 0 to time 1.
struct MovingPoint {
    Vec3d start, end;
};

}  // namespace pierce
