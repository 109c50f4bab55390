#include "bullet/calm_watch.hpp"

#include <BulletDynamics/Dynamics/btRigidBody.h>

namespace pierce::bullet {
namespace {

/// How far a calm body may be from its earlier place [way that gravity moves a body in its first
/// step]. Contacts that come and go let a body at rest vibrate by one or two. A falling body is
/// further away than this within a dozen steps, even around the top of a throw.
constexpr btScalar calm_ways = 10;

}  // namespace

/// True if the nodes are on average (root mean square) no further than `within` from their places.
bool CalmWatch::stays(const btSoftBody& soft, btScalar within) const {
    if (static_cast<int>(places_.size()) != soft.m_nodes.size()) return false;
    btScalar sum = 0;
    for (int i = 0; i < soft.m_nodes.size(); ++i)
        sum += soft.m_nodes[i].m_x.distance2(places_[static_cast<std::size_t>(i)]);
    return sum <= within * within * static_cast<btScalar>(soft.m_nodes.size());
}

void CalmWatch::note(btSoftBody& soft, btScalar dt) {
    if (stays(soft, calm_ways * soft.m_worldInfo->m_gravity.length() * dt * dt)) {
        soft.setDeactivationTime(soft.getDeactivationTime() + dt);
    } else {
        places_.clear();
        for (int i = 0; i < soft.m_nodes.size(); ++i) places_.push_back(soft.m_nodes[i].m_x);
        soft.setDeactivationTime(0);
    }
    const bool tired = !gDisableDeactivation && soft.getDeactivationTime() > gDeactivationTime;
    soft.setActivationState(tired ? WANTS_DEACTIVATION : ACTIVE_TAG);
}

}  // namespace pierce::bullet
