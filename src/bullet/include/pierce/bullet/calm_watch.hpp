#pragma once

#include <BulletSoftBody/btSoftBody.h>

#include <vector>

namespace pierce::bullet {

/// How long a soft body has stayed where it is, vibration aside.
class CalmWatch {
public:
    /// After a step of `dt` [s]: a body that has stayed for Bullet's `gDeactivationTime` asks
    /// Bullet to let its island sleep.
    void note(btSoftBody& soft, btScalar dt);

private:
    bool stays(const btSoftBody& soft, btScalar within) const;

    std::vector<btVector3> places_;  ///< of the nodes, when the watch was started
};

}  // namespace pierce::bullet
