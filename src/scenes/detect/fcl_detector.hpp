#pragma once

#include <memory>

#include "scenes/detect/detector.hpp"

namespace pierce::scenes {

/// All contacts between triangles by FCL: trees of oriented boxes and swept spheres (OBBRSS), pairs
/// from its dynamic tree of boxes. Throws InputError if this build has no FCL.
std::unique_ptr<Detector> make_fcl_detector(const SceneSetup& scene);

}  // namespace pierce::scenes
