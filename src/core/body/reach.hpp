#pragma once

#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"
#include "pierce/min_max.hpp"
#include "pierce/pose.hpp"

namespace pierce {

/// Where a body is, as far as its points alone tell.
struct PlacedBox {
    Box box;            ///< around the points in the world; empty if a pose is unusable
    double travel = 0;  ///< [length] no point has moved further since the step began
};

/// Where the points are whose box in their own space is `local`, without their way.
PIERCE_HD inline PlacedBox placed_box(const Box& local, const Frame& space) {
    PlacedBox place;
    for (int k = 0; k < 8; ++k)
        place.box.extend(space.to_parent({(k & 1 ? local.upper : local.lower).x,
                                          (k & 2 ? local.upper : local.lower).y,
                                          (k & 4 ? local.upper : local.lower).z}));
    return place;
}

/// A box in the world that holds all that a body may have to do with in a step: no body whose box
/// is apart from it is a pair with this one. It is found without a step; empty for a body that is
/// nowhere. `more`: how far the body may have to do with others beyond its points.
PIERCE_HD inline Box reach_of(const PlacedBox& place, double more) {
    if (place.box.empty()) return {};
    // Steps measure boxes in several frames, with a touch tolerance for each; the diagonal is at
    // most sqrt(3) times as long as that of a box in another frame, and 16 covers their sum.
    const double touch = 16 * constants::touch_tolerance *
                         (place.box.extent() + place.box.max_coordinate());
    return place.box.inflated(touch + place.travel + more);
}

/// [length] How much further a body reaches now than before, at most; infinity if it has reached
/// nowhere.
PIERCE_HD inline double growth_of(const Box& before, const Box& now) {
    if (now.empty()) return 0;
    double most = 0;
    for (int k = 0; k < 3; ++k)
        most = max_of(now.upper[k] - before.upper[k], max_of(before.lower[k] - now.lower[k], most));
    return most;
}

}  // namespace pierce
