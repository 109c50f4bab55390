#pragma once

#include "pierce/core/contact.hpp"

namespace pierce {

/// A spring and a damper along a contact's ray.
struct PenaltySettings {
    double stiffness = 0;  ///< force per length
    double damping = 0;    ///< force per speed
};

/// The force of a contact on the vertex and on the corners of the triangle it went through.
struct PenaltyForce {
    Vec3d direction;  ///< unit, the way the vertex is pushed
    Vec3d on_vertex;
    Vec3d on_corner[3];
};

/// Velocities of the corners of a contact's triangle.
struct CornerVelocities {
    Vec3d corner[3];
};

/// Hermann, Faure and Raffin (2008): pushes the vertex along its ray towards the target point, and the target the other way,
/// spread by the barycentric weights. The force acts along the line between its two points, so linear and angular momentum
/// are kept to rounding, whatever the mesh's normals are like. Never pulls.
inline PenaltyForce penalty_force(const Contact& contact, const PenaltySettings& settings, Vec3d vertex_velocity,
                                  const CornerVelocities& corners) {
    PenaltyForce force;
    force.direction = contact.source == Side::a ? -contact.normal : contact.normal;
    Vec3d target_velocity;
    for (int k = 0; k < 3; ++k) target_velocity += contact.barycentric[k] * corners.corner[k];
    const double speed = dot(vertex_velocity - target_velocity, force.direction);
    const double size = max_of(settings.stiffness * contact.penetration_depth() - settings.damping * speed, 0.0);
    force.on_vertex = size * force.direction;
    for (int k = 0; k < 3; ++k) force.on_corner[k] = -contact.barycentric[k] * force.on_vertex;
    return force;
}

}  // namespace pierce
