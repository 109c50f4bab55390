#pragma once

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBody.h>

#include "pierce/contact.hpp"

namespace pierce::bullet {

/// A vertex of one soft body inside another one: Bullet's own node-against-face contact, for its
/// soft solver. Of an edge, each end gets one with its weight, as deep as the point between them.
void add_soft_soft(btSoftBody& source, btSoftBody& target, const Contact& contact);

/// A vertex, or both ends of an edge, of a soft body inside a rigid one: Bullet's own
/// node-against-plane contact with the face that was hit.
void add_soft_rigid(btSoftBody& source, const btCollisionObject& target, const Contact& contact);

/// A vertex of a rigid body inside a soft one: the face that was hit has to move behind the vertex.
/// Each of its nodes gets a contact with a plane that asks for the whole way, and shares the rigid
/// body's mass by its barycentric weight.
void add_rigid_soft(const btCollisionObject& source, btSoftBody& target, const Contact& contact);

}  // namespace pierce::bullet
