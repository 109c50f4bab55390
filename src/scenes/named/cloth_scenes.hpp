#pragma once

#include "scenes/named/scene.hpp"

namespace pierce::scenes {

/// A square sheet of 20 x 20 vertices 0.4 apart falls on a capsule that lies above the ground, and
/// onto itself (the paper's section 6.6). More vertices make it finer, not larger.
SceneSetup cloth_capsule(const SceneParameters& parameters);

/// One edge of a sheet that lies on the ground is led over to the opposite edge, and let go.
SceneSetup cloth_fold(const SceneParameters& parameters);

/// Solids fall into a sheet that is held at its corners.
SceneSetup cloth_catch(const SceneParameters& parameters);

/// A tube of cloth, held at both ends, is wrung.
SceneSetup cloth_twist(const SceneParameters& parameters);

/// A closed soft bag, thick-walled like a bowl, is pressed flat between two plates, so that its
/// inner wall meets itself.
SceneSetup ball_squash(const SceneParameters& parameters);

}  // namespace pierce::scenes
