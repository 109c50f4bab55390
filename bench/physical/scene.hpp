#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "pierce/pose.hpp"
#include "scenes/named/scene.hpp"

namespace pierce::physical {

/// A rigid body at its start.
struct Body {
    std::uint32_t mesh = 0;
    Pose pose = {};
    Vec3d velocity = {};          ///< [length / s]
    Vec3d angular_velocity = {};  ///< [rad / s]
    bool fixed = false;
};

/// What is left of a scene after its last step.
struct Ending {
    std::span<const Pose> poses;  ///< by body
    double moved = 0;             ///< [length] farthest any vertex is from its place 10 s earlier
};

struct Verdict {
    bool intact = false;
    std::string words;  ///< the figures that decide
};

/// A scene of rigid bodies for which mechanics says how it must end. Lengths in metres, density 1.
struct Scene {
    std::string name;
    std::vector<scenes::SceneMesh> meshes;
    std::vector<Body> bodies;
    double gravity = 9.81;  ///< [m/s^2] along -z
    bool may_sleep = true;
    bool has_ground = false;  ///< a fixed body with a flat upper side
    std::function<Verdict(const Ending&)> judge;
};

/// The names of all scenes.
std::span<const std::string> scene_names();

/// Starts of a scene differ a little from each other. Throws InputError for an unknown name.
Scene make_scene(const std::string& name, std::uint32_t start = 0);

}  // namespace pierce::physical
