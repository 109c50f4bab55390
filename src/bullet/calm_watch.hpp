#pragma once

#include <BulletSoftBody/btSoftBody.h>

#include <vector>

namespace pierce::bullet {

/// Measures how long a soft body has stayed at its place, apart from vibration.
class CalmWatch {
public:
    /// To be called after a step of `dt` [s]. A body that has stayed for Bullet's
    /// `gDeactivationTime` asks Bullet to let its island sleep.
    void note(btSoftBody& soft, btScalar dt);

private:
    bool stays(const btSoftBody& soft, btScalar within) const;

    std::vector<btVector3> places_;  ///< of the nodes, when the watch was started
};

}  // namespace pierce::bullet
