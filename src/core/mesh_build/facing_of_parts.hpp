#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh_build/connected_parts.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Which way a part of a surface faces. Where the surface is open, generalized winding numbers say
/// what lies in what.
enum class Facing : std::uint8_t {
    outward,
    inward,  ///< it has a negative volume, and does not lie in others as the wall of a cavity does
    in_inward  ///< it has a positive volume, and lies in a part that faces inward: with all of it,
               ///< it is inside out
};

/// The facing of each connected part.
std::vector<Facing> facing_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                              const ConnectedParts& parts, Workers& workers);

}  // namespace pierce
