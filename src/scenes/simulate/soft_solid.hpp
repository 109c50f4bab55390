#pragma once

#include <BulletSoftBody/btSoftBody.h>

#include <memory>

#include "scenes/named/scene.hpp"

namespace pierce::scenes {

/// A solid that deforms as Bullet simulates it: a node per vertex, a link per edge, bending links,
/// and a face per triangle. Bullet's collisions are off.
std::unique_ptr<btSoftBody> soft_solid(btSoftBodyWorldInfo& info, const SceneBody& body,
                                       const MeshData& mesh);

}  // namespace pierce::scenes
