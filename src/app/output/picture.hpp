#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "pierce/world.hpp"
#include "scenes/named/scene.hpp"

namespace pierce::app {

/// The bodies of a scene's world that are its ground.
std::vector<BodyId> ground_of(const scenes::SceneSetup& scene);

/// The box around all bodies of the world's last step but the ground; around the ground where there
/// are no others, and around the origin where there is nothing.
Box box_of_bodies(const World& world, std::span<const BodyId> ground);

/// What a picture shows.
struct Shot {
    Box around;             ///< what the camera looks at
    double deepest = 0;     ///< [length] the penetration that is red; 0: the deepest one
    bool contacts = false;  ///< a dot for each, in front of all bodies
};

/// Writes a PNG of the bodies as they stood in the world's last step, traced through the same trees
/// as the contacts. Bodies are grey where they touch nothing and go from yellow to red with their
/// deepest penetration; `ground` stays pale.
void write_picture(World& world, std::span<const BodyId> ground, const Shot& shot,
                   const std::filesystem::path& file);

}  // namespace pierce::app
