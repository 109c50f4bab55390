#pragma once

#include <cstdint>

#include "core/mesh/mesh_view.hpp"
#include "pierce/vec3.hpp"

namespace pierce::bullet {

/// True if no triangle at a vertex reaches much further along `way` [unit, in the mesh's space]
/// than the vertex: if it is the closest place of its surroundings to what lies there.
bool is_foremost(const MeshView& mesh, std::uint32_t vertex, Vec3d way);

/// The same for an edge.
bool is_foremost(const MeshView& mesh, std::uint32_t from, std::uint32_t to, Vec3d way);

}  // namespace pierce::bullet
