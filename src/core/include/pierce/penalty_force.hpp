#pragma once

#include "pierce/contact.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// A spring and a damper along a contact's ray.
struct PenaltySettings {
    double stiffness = 0;  ///< force per length
    double damping = 0;    ///< force per speed
};

/// The force of a contact on the vertices it starts from and on the corners of the triangle that
/// the ray leaves through.
struct PenaltyForce {
    Vec3d direction;     ///< unit, the way the source is pushed
    Vec3d on_source[2];  ///< on `vertex`, and on `edge_end` if an edge is in contact
    Vec3d on_corner[3];
};

/// Velocities of the vertices a contact lies between.
struct ContactVelocities {
    Vec3d source[2];
    Vec3d corner[3];
};

/// Hermann, Faure and Raffin (2008): pushes the source along its ray towards the target point, and
/// the target the other way, spread by the weights of the vertices. The force acts along the line
/// between its two points, so linear and angular momentum are kept to rounding, whatever the mesh's
/// normals are like. Never pulls.
inline PenaltyForce penalty_force(const Contact& contact, const PenaltySettings& settings,
                                  const ContactVelocities& velocities) {
    PenaltyForce force;
    force.direction = contact.source == Side::a ? -contact.normal : contact.normal;
    Vec3d apart;
    for (int k = 0; k < 2; ++k) apart += contact.source_weight(k) * velocities.source[k];
    for (int k = 0; k < 3; ++k) apart += -contact.barycentric[k] * velocities.corner[k];
    const double speed = dot(apart, force.direction);
    const double size = max_of(
        settings.stiffness * contact.penetration_depth() - settings.damping * speed, 0.0);
    const Vec3d push = size * force.direction;
    for (int k = 0; k < 2; ++k) force.on_source[k] = contact.source_weight(k) * push;
    for (int k = 0; k < 3; ++k) force.on_corner[k] = -contact.barycentric[k] * push;
    return force;
}

}  // namespace pierce
