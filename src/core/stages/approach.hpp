#pragma once

#include "pierce/core/body.hpp"
#include "pierce/core/settings.hpp"

/// How near predictions expect the vertices of a body to come to another one.
namespace pierce::stages {

/// How far points of a source move relative to a target until the next full pass, if they go on as in the last step.
struct Approach {
    Matrix3 turn = {{{}, {}, {}}};  ///< a point x of the source's space goes by turn * x + shift, in the target's fit
    Vec3d shift;
    double spin = 0;   ///< how much further a point goes per length that it is away from another one
    double shape = 0;  ///< [length] how much further, as both bodies change their shapes
    double most = 0;   ///< [length] nobody looks further than this; zero: nothing is predicted

    /// How far outside the target a ball around `center`, in the source's space, is of interest.
    PIERCE_HD double reach(Vec3d center, double radius) const {
        return most > 0 ? min_of(length(turn * center + shift) + spin * radius + shape, most) : 0;
    }
};

/// The approach of the bodies of a directed pair: what is not known of their motion is bounded by their reach.
PIERCE_HD inline Approach approach_of(const BodyView& source, const BodyView& target, const Settings& settings) {
    Approach a;
    a.shape = a.most = source.reach + target.reach;
    if (!(a.most > 0) || !source.seen || !target.seen) return a;
    const Frame before = relative_frame(source.last_fit, target.last_fit), now = relative_frame(source.fit, target.fit);
    const double steps = settings.full_every;
    double squared = 0;
    for (int r = 0; r < 3; ++r) {
        a.turn.row[r] = steps * (now.rotation.row[r] - before.rotation.row[r]);
        squared += length_squared(a.turn.row[r]);
    }
    a.shift = steps * (now.origin - before.origin);
    a.spin = std::sqrt(0.5 * squared);
    a.shape = steps * (source.shape_motion + target.shape_motion);
    if (source.motion == Motion::deforming) {  // its space is the world
        const Frame to_fit = source.fit.inverse();
        a.shift += a.turn * to_fit.origin;
        a.turn = a.turn * to_fit.rotation;
    }
    return a;
}

}  // namespace pierce::stages
