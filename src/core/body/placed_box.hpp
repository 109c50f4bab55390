#pragma once

#include "pierce/box.hpp"

namespace pierce {

/// Where a body is, as far as its points alone tell.
struct PlacedBox {
    Box box;            ///< around the points in the world; empty if a pose is unusable
    double travel = 0;  ///< [length] no point has moved further since the step began
};

}  // namespace pierce
