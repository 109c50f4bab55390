#pragma once

#include <BulletSoftBody/btSoftBody.h>

namespace pierce::bullet {

/// After a step: a body that has been calm for Bullet's `gDeactivationTime` asks Bullet to let its island sleep. It is calm
/// while its nodes' root mean square speed is below a tenth of what gravity gives in a step.
void note_calm(btSoftBody& soft, btScalar dt);

}  // namespace pierce::bullet
