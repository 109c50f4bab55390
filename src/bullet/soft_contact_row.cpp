#include "bullet/soft_contact_row.hpp"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>

namespace pierce::bullet {
namespace {

btVector3 point_of(const btSoftBody::Face& face, const btVector3& weights,
                   btVector3 btSoftBody::Node::*position) {
    return btSoftBody::BaryEval(face.m_n[0]->*position, face.m_n[1]->*position,
                                face.m_n[2]->*position, weights);
}

Grip grip_at(const btSoftBody& target, const btSoftBody::Face& face, const btVector3& weights,
             const btVector3& gap) {
    Grip grip{.node = {}, .place = weights, .gap = gap, .end = {}};
    for (int k = 0; k < 3; ++k) grip.node[k] = static_cast<int>(face.m_n[k] - &target.m_nodes[0]);
    return grip;
}

/// True if the target still has the nodes: it may have lost some.
bool has_nodes(const btSoftBody& target, const Grip& grip) {
    return std::ranges::all_of(grip.node, [&](int node) { return node < target.m_nodes.size(); });
}

}  // namespace

SoftContactRow::SoftContactRow(const btSoftBody& source, const btSoftBody::RContact& contact,
                               const Grip* grip)
    : rigid_(&contact),
      node_(contact.m_node),
      normal_(contact.m_cti.m_normal),
      margin_(-contact.m_cti.m_offset),
      friction_(source.m_cfg.kDF * contact.m_cti.m_colObj->getFriction()),
      dt_(source.m_sst.sdt),
      stays_(grip != nullptr) {
    // Hardness is of the depth that the step begins with. Motion into the target is taken away as a
    // whole, as by Bullet's own solver.
    const btScalar begin = margin_ - normal_.dot(node_->m_q);
    left_ = (1 - contact.m_c4) * btMax(btScalar(0), begin);
    held_ = node_->m_q;
    if (grip == nullptr) return;
    grip_ = *grip;
    // Bullet has already moved its rigid bodies.
    held_ = contact.m_cti.m_colObj->getWorldTransform() * grip_.place - carried();
}

SoftContactRow::SoftContactRow(const btSoftBody::SContact& contact, btSoftBody& target,
                               const Grip* grip)
    : soft_(&contact),
      target_(&target),
      node_(contact.m_node),
      normal_(contact.m_normal),
      margin_(contact.m_margin),
      friction_(contact.m_friction),
      stays_(grip != nullptr && has_nodes(target, *grip)) {
    if (stays_)
        grip_ = *grip;
    else
        grip_ = grip_at(
            target, *contact.m_face, contact.m_weights,
            node_->m_q - point_of(*contact.m_face, contact.m_weights, &btSoftBody::Node::m_q));
}

/// How a rigid target moves the contact in this step.
btVector3 SoftContactRow::carried() const {
    const btRigidBody* body = btRigidBody::upcast(rigid_->m_cti.m_colObj);
    return body != nullptr ? body->getVelocityInLocalPoint(rigid_->m_c1) * dt_ : btVector3(0, 0, 0);
}

btVector3 SoftContactRow::from_target() const {
    if (rigid_ != nullptr) return node_->m_x - carried();
    return node_->m_x - point_of(*soft_->m_face, soft_->m_weights, &btSoftBody::Node::m_x);
}

btVector3 SoftContactRow::from_grip() const {
    if (rigid_ != nullptr) return node_->m_x - carried() - held_;
    const btVector3 place = btSoftBody::BaryEval(target_->m_nodes[grip_.node[0]].m_x,
                                                 target_->m_nodes[grip_.node[1]].m_x,
                                                 target_->m_nodes[grip_.node[2]].m_x, grip_.place);
    return node_->m_x - place - grip_.gap;
}

void SoftContactRow::move(const btVector3& way) {
    if (rigid_ != nullptr) {
        const btVector3 impulse = rigid_->m_c0 * way;
        node_->m_x += impulse * rigid_->m_c2;
        // Only the contacts hold the object as const; the solver owns it.
        if (auto* body = const_cast<btRigidBody*>(btRigidBody::upcast(rigid_->m_cti.m_colObj)))
            body->applyImpulse(-impulse, rigid_->m_c1);
        return;
    }
    node_->m_x += way * soft_->m_cfm[0];
    for (int k = 0; k < 3; ++k)
        soft_->m_face->m_n[k]->m_x -= way * (soft_->m_cfm[1] * soft_->m_weights[k]);
}

void SoftContactRow::solve() {
    const btScalar depth = margin_ - left_ - normal_.dot(from_target());
    const btScalar push = btMax(btScalar(0), push_ + depth);
    move(normal_ * (push - push_));
    push_ = push;

    const btVector3 off = from_grip();
    btVector3 hold = hold_ - (off - normal_ * normal_.dot(off));
    const btScalar size = hold.length(), reach = friction_ * push_;
    const bool slides = size > reach;
    if (slides) hold *= reach / size;
    stays_ = stays_ && !slides;
    move(hold - hold_);
    hold_ = hold;
}

Grip SoftContactRow::grip() const {
    Grip grip = grip_;
    if (!stays_ && rigid_ != nullptr)
        grip.place = rigid_->m_cti.m_colObj->getWorldTransform().invXform(node_->m_x);
    if (!stays_ && rigid_ == nullptr)
        grip = grip_at(*target_, *soft_->m_face, soft_->m_weights, from_target());
    grip.end = node_->m_x;
    return grip;
}

}  // namespace pierce::bullet
