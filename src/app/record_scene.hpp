#pragma once

#include <string>

#include "pierce/scenes/recording.hpp"

namespace pierce::app {

/// The motion of a named scene, simulated with contacts from rays.
scenes::Recording record_scene(const std::string& name, const scenes::SceneParameters& parameters, double seconds,
                               double dt);

}  // namespace pierce::app
