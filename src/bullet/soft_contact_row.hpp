#pragma once

#include <BulletSoftBody/btSoftBody.h>

namespace pierce::bullet {

/// The place on a target that a node in contact holds on to.
struct Grip {
    int node[3] = {};  ///< of a soft target: the nodes of the face, by index
    btVector3 place;   ///< of a soft target: their weights; of other targets: a point in the
                       ///< target's frame
    btVector3 gap;     ///< of a soft target: from the place to the node
    btVector3 end;     ///< where the step has left the node
};

/// A node's contact while a step is solved. The pushes that the node has been given are summed up:
/// the sum never pulls, and it bounds friction.
class SoftContactRow {
public:
    /// A contact with a rigid body or another fixed object; `grip`: of the step before, or null if
    /// the contact is new.
    SoftContactRow(const btSoftBody& source, const btSoftBody::RContact& contact, const Grip* grip);
    /// A contact with another soft body, `target`, to which the contact's face belongs.
    SoftContactRow(const btSoftBody::SContact& contact, btSoftBody& target, const Grip* grip);

    /// Pushes the node out of the target, then back to the place it holds on to, as far as friction
    /// reaches.
    void solve();

    /// False if the node touches without being pushed.
    bool presses() const { return push_ > 0; }
    /// After solving: the place that the node held on to, or the node's present place if the
    /// contact is new or slides.
    Grip grip() const;

private:
    btVector3 from_target() const;
    btVector3 from_grip() const;
    btVector3 carried() const;
    void move(const btVector3& way);

    const btSoftBody::RContact* rigid_ = nullptr;
    const btSoftBody::SContact* soft_ = nullptr;
    btSoftBody* target_ = nullptr;  ///< if soft
    btSoftBody::Node* node_;
    btVector3 normal_;
    btScalar margin_, friction_, dt_ = 0;
    btScalar left_ = 0;  ///< [length] depth in a rigid target that this step does not take away; of
                         ///< soft ones, the contact's shares include the hardness
    bool stays_;         ///< the node holds on to a place of the step before, unless it slides
    Grip grip_;
    btVector3 held_;  ///< of rigid targets: the place before the step
    btScalar push_ = 0;
    btVector3 hold_{0, 0, 0};  ///< the motion by friction so far
};

}  // namespace pierce::bullet
