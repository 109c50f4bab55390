#pragma once

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBody.h>

#include "pierce/contact.hpp"

namespace pierce::bullet {

/// Adds a contact of a vertex of one soft body inside another one: Bullet's own node-against-face
/// contact, for its soft solver, which keeps the address of `face` for the step. Of an edge, each
/// end gets such a contact with its weight, as deep as the point between the ends.
void add_soft_soft(btSoftBody& source, btSoftBody::Face& face, const btSoftBody& target,
                   const Contact& contact);

/// Adds a contact of a vertex, or of both ends of an edge, of a soft body inside a rigid one:
/// Bullet's own node-against-plane contact with the face that was hit.
void add_soft_rigid(btSoftBody& source, const btCollisionObject& target, const Contact& contact);

/// Adds a contact of a vertex of a rigid body inside a soft one: the face that was hit has to move
/// behind the vertex. Each node of the face gets a contact with a plane that asks for the whole
/// way, and shares the rigid body's mass by the node's barycentric weight.
void add_rigid_soft(const btCollisionObject& source, btSoftBody::Face& face, btSoftBody& target,
                    const Contact& contact);

}  // namespace pierce::bullet
