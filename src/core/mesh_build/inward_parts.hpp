#pragma once

#include <span>
#include <vector>

#include "core/mesh_build/connected_parts.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Per connected part of a surface: it faces inward, and has to be turned around. That is a part
/// with a negative volume that does not lie in others, as the wall of a cavity does; and a part
/// with a positive volume in one that faces inward: all of it is inside out. Where the surface is
/// open, generalized winding numbers say what lies in what.
std::vector<bool> inward_parts(std::span<const Vec3f> positions,
                               std::span<const Triangle> triangles, const ConnectedParts& parts);

}  // namespace pierce
