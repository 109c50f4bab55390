#pragma once

#include <cstdint>

#include "core/body/body_view.hpp"
#include "pierce/body.hpp"
#include "pierce/min_max.hpp"

/// How near predictions expect the vertices of a body to come to another one.
namespace pierce::stages {

/// How far points of a source move relative to a target until the next full pass, if they go on as
/// their fits, and the source's patches within it, did in the last step. Where the target changes
/// its shape, its own vertices look ahead.
struct Approach {
    Matrix3 turn;  ///< a point x of the source's space moves by turn * x + shift, in the target's
                   ///< fit
    Vec3d shift;
    double spin = 0;  ///< how much further a point goes per length that it is away from another one
    double most = 0;  ///< [length] no prediction looks further than this; zero: nothing is
                      ///< predicted
    bool known = false;  ///< if false, any point may move by `most`
    std::uint8_t padding[3] = {};
    float steps = 0;  ///< for how many steps a change of the source's shape goes on; zero: it has
                      ///< none

    /// How far outside the target a ball around `center`, in the source's space, is of interest,
    /// if its points move within the source by `change` at most in a step.
    PIERCE_HD double reach(Vec3d center, double radius, double change = 0) const {
        if (!known) return most;
        return min_of(length(turn * center + shift) + spin * radius + steps * change, most);
    }
};

/// The approach over some steps of bodies that were seen in the last one; `now`: the source's fit
/// to the target's.
PIERCE_HD inline Approach approach_of(const BodyView& source, const BodyView& target,
                                      const Frame& now, double steps) {
    const Frame before = relative_frame(source.last_fit, target.last_fit);
    Approach a;
    double squared = 0;
    for (int r = 0; r < 3; ++r) {
        a.turn.row[r] = steps * (now.rotation.row[r] - before.rotation.row[r]);
        squared += length_squared(a.turn.row[r]);
    }
    a.shift = steps * (now.origin - before.origin);
    a.spin = std::sqrt(0.5 * squared);
    a.most = source.prediction_range + target.prediction_range;
    a.known = true;
    if (source.motion == Motion::deforming) {  // its space is the world
        a.steps = static_cast<float>(steps);
        const Frame to_fit = source.fit.inverse();
        a.shift += a.turn * to_fit.origin;
        a.turn = a.turn * to_fit.rotation;
    }
    return a;
}

}  // namespace pierce::stages
