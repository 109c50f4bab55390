#pragma once

#include <nlohmann/json_fwd.hpp>

#include "pierce/contact.hpp"
#include "scenes/detect/method.hpp"

namespace pierce::app {

/// A point or direction, as commands write it.
nlohmann::json xyz(Vec3d v);

/// What runs the rays and how, as commands write it.
nlohmann::json rays_json(const scenes::RaySettings& rays);

/// A contact, as commands write it; bodies by their index.
nlohmann::json contact_json(const Contact& contact);

}  // namespace pierce::app
