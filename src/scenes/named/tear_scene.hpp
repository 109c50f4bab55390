#pragma once

#include "scenes/named/scene.hpp"

namespace pierce::scenes {

/// A sheet and a soft solid are held at both ends and pulled until they tear; then they are let go,
/// and the parts of the sheet fall on those of the solid.
SceneSetup tear(const SceneParameters& parameters);

}  // namespace pierce::scenes
