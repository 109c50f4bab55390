#pragma once

#include "core/body/body_view.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/min_max.hpp"

/// The rules that make a ray's hit a contact, and the one that spares a vertex its ray. Stages and
/// explain() ask them here. Source of R1 to R3: Hermann, Faure and Raffin (2008).
namespace pierce::rules {

/// How far a point is from a target for certain [length].
struct Gap {
    double beyond_box = 0;  ///< from the target's fitted box
    double clearance = 0;   ///< from the target's surface, less its deviation; may be negative

    /// True if rounding may hide that the point is inside.
    PIERCE_HD bool may_be_inside(double touch) const {
        return !(max_of(beyond_box, clearance) > 2 * touch);
    }
};

/// The gap of a point given in the target's fit. BallsNearby (vertex_cull.hpp) computes the same
/// for sixteen balls at once, in float32 with its rounding added.
PIERCE_HD inline Gap gap_to(const BodyView& target, Vec3d in_fit) {
    return {target.fit_box.distance(in_fit), target.mesh.clearance()(in_fit) - target.deviation};
}

/// R1: the ray leaves the target at its first crossing, so it starts inside.
PIERCE_HD inline bool starts_inside(const Meeting& target) { return target.exit; }

/// R2, by a ray into its own body, without the triangles around its start: the first crossing
/// leaves that body.
PIERCE_HD inline bool starts_in_own(const Meeting& own) { return own.exit; }

/// R3: the ray leaves the target before its own body, or at the same place. Both lengths from the
/// ray's start.
PIERCE_HD inline bool leaves_target_first(double target_exit, double own_exit, double touch) {
    return target_exit <= own_exit + touch;
}

}  // namespace pierce::rules
