#pragma once

#include <filesystem>
#include <span>

#include "pierce/world.hpp"

namespace pierce::app {

/// Writes a PNG of the bodies as they stood in the world's last step, traced through the same trees
/// as the contacts. Bodies are grey where they touch nothing and go from yellow to red with their
/// deepest penetration; `ground` stays pale.
void write_picture(World& world, std::span<const BodyId> ground, const std::filesystem::path& file);

}  // namespace pierce::app
