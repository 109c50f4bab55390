#include "pierce/bullet/soft_solver.hpp"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyInternals.h>

#include <algorithm>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "bullet/calm_watch.hpp"
#include "bullet/soft_contact_row.hpp"

namespace pierce::bullet {
namespace {

/// A node and the object it touches. The key is only used for look-ups, so no result depends on the
/// order of addresses.
using Touch = std::pair<const btSoftBody::Node*, const btCollisionObject*>;

/// Finds the body that a node belongs to.
class NodeOwners {
public:
    explicit NodeOwners(const btAlignedObjectArray<btSoftBody*>& bodies) {
        for (int i = 0; i < bodies.size(); ++i)
            if (bodies[i]->m_nodes.size() > 0) by_first_.emplace(&bodies[i]->m_nodes[0], bodies[i]);
    }
    btSoftBody& of(const btSoftBody::Node* node) const {
        return *std::prev(by_first_.upper_bound(node))->second;
    }

private:
    std::map<const btSoftBody::Node*, btSoftBody*, std::less<>> by_first_;
};

void prepare_anchors(btSoftBody& soft) {
    for (int i = 0; i < soft.m_anchors.size(); ++i) {
        btSoftBody::Anchor& anchor = soft.m_anchors[i];
        btRigidBody& body = *anchor.m_body;
        anchor.m_c1 = body.getWorldTransform().getBasis() * anchor.m_local;
        anchor.m_c0 = ImpulseMatrix(soft.m_sst.sdt, anchor.m_node->m_im, body.getInvMass(),
                                    body.getInvInertiaTensorWorld(), anchor.m_c1);
        anchor.m_c2 = soft.m_sst.sdt * anchor.m_node->m_im;
        body.activate();
    }
}

void finish(btSoftBody& soft) {
    const btScalar rate = soft.m_sst.isdt * (1 - soft.m_cfg.kDP);
    for (int i = 0; i < soft.m_nodes.size(); ++i) {
        btSoftBody::Node& node = soft.m_nodes[i];
        node.m_v = (node.m_x - node.m_q) * rate;
        node.m_f.setZero();
    }
}

// True if the body touches an active kinematic object. Bullet's islands hold only bodies that move
// by themselves, but a led body wakes soft bodies that touch it, as it wakes rigid bodies.
bool touches_led_body(const btSoftBody& soft) {
    for (int i = 0; i < soft.m_rcontacts.size(); ++i) {
        const btCollisionObject& object = *soft.m_rcontacts[i].m_cti.m_colObj;
        if (object.isKinematicObject() && object.isActive()) return true;
    }
    return false;
}

void put_back(btSoftBody& soft) {
    for (int i = 0; i < soft.m_nodes.size(); ++i) {
        btSoftBody::Node& node = soft.m_nodes[i];
        node.m_x = node.m_q;
        node.m_v.setZero();
        node.m_f.setZero();
    }
}

}  // namespace

struct SoftSolver::State {
    std::map<Touch, Grip> grips;                     ///< the grips of the last step
    std::map<const btSoftBody*, CalmWatch> watches;  ///< for the bodies that are awake

    const Grip* grip_of(const Touch& touch) const {
        const auto found = grips.find(touch);
        // The program may have put the node elsewhere.
        return found != grips.end() && found->second.end == touch.first->m_q ? &found->second
                                                                             : nullptr;
    }
};

SoftSolver::SoftSolver() : state_(std::make_unique<State>()) {}
SoftSolver::~SoftSolver() = default;

// Sleeping bodies are predicted, too, and put back later. So their contacts are found as if they
// were awake, and a body that wakes does not jump.
void SoftSolver::predictMotion(btScalar dt) {
    for (int i = 0; i < m_softBodySet.size(); ++i)
        if (m_softBodySet[i]->getActivationState() != DISABLE_SIMULATION)
            m_softBodySet[i]->predictMotion(dt);
}

void SoftSolver::solveConstraints(btScalar dt) {
    struct Part {
        btSoftBody* body;
        std::size_t rows_end;
    };
    const NodeOwners owners(m_softBodySet);
    std::vector<Part> parts;
    std::vector<SoftContactRow> rows;
    std::vector<Touch> touches;
    int iterations = 0;
    for (int i = 0; i < m_softBodySet.size(); ++i) {
        btSoftBody& body = *m_softBodySet[i];
        if (body.getActivationState() == ISLAND_SLEEPING && touches_led_body(body)) body.activate();
        if (body.getActivationState() == ISLAND_SLEEPING) put_back(body);
        if (!body.isActive()) continue;
        prepare_anchors(body);
        for (int k = 0; k < body.m_rcontacts.size(); ++k) {
            const btSoftBody::RContact& contact = body.m_rcontacts[k];
            if (!contact.m_cti.m_colObj->hasContactResponse()) continue;
            touches.emplace_back(contact.m_node, contact.m_cti.m_colObj);
            rows.emplace_back(body, contact, state_->grip_of(touches.back()));
        }
        for (int k = 0; k < body.m_scontacts.size(); ++k) {
            const btSoftBody::SContact& contact = body.m_scontacts[k];
            btSoftBody& target = owners.of(contact.m_face->m_n[0]);
            touches.emplace_back(contact.m_node, &target);
            rows.emplace_back(contact, target, state_->grip_of(touches.back()));
        }
        parts.push_back({&body, rows.size()});
        iterations = std::max(iterations, body.m_cfg.piterations);
    }

    for (int k = 0; k < iterations; ++k) {
        std::size_t row = 0;
        for (const Part& part : parts) {
            btSoftBody::PSolve_Anchors(part.body, 1, 0);
            while (row < part.rows_end) rows[row++].solve();
            btSoftBody::PSolve_Links(part.body, 1, 0);
        }
    }
    std::map<const btSoftBody*, CalmWatch> watches;
    for (const Part& part : parts) {
        finish(*part.body);
        CalmWatch& watch = watches[part.body] = std::move(state_->watches[part.body]);
        watch.note(*part.body, dt);
    }
    state_->watches = std::move(watches);

    state_->grips.clear();
    for (std::size_t r = 0; r < rows.size(); ++r)
        if (rows[r].presses()) state_->grips.insert_or_assign(touches[r], rows[r].grip());
}

}  // namespace pierce::bullet
