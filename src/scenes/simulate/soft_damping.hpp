#pragma once

#include <BulletSoftBody/btSoftBody.h>

namespace pierce::scenes {

/// Takes away `share` of every node's velocity relative to the body's motion as a whole: the
/// damping inside a material. Momentum and angular momentum do not change. Bullet's own damping
/// slows the whole body down, falling included.
void damp_vibration(btSoftBody& soft, btScalar share);

}  // namespace pierce::scenes
