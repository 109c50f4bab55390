#include "pierce/bullet/soft_sleep.hpp"

#include <BulletDynamics/Dynamics/btRigidBody.h>

namespace pierce::bullet {
namespace {

/// Of the speed that gravity gives in a step: what solving leaves over is well below it, what slides or falls passes it
/// within a step.
constexpr btScalar calm_share = btScalar(0.1);

btScalar mean_square_speed(const btSoftBody& soft) {
    btScalar sum = 0;
    for (int i = 0; i < soft.m_nodes.size(); ++i) sum += soft.m_nodes[i].m_v.length2();
    return sum / static_cast<btScalar>(soft.m_nodes.size());
}

}  // namespace

void note_calm(btSoftBody& soft, btScalar dt) {
    const btVector3 limit = soft.m_worldInfo->m_gravity * (calm_share * dt);
    const bool calm = mean_square_speed(soft) < limit.length2();
    soft.setDeactivationTime(calm ? soft.getDeactivationTime() + dt : btScalar(0));
    const bool tired = !gDisableDeactivation && soft.getDeactivationTime() > gDeactivationTime;
    soft.setActivationState(tired ? WANTS_DEACTIVATION : ACTIVE_TAG);
}

}  // namespace pierce::bullet
