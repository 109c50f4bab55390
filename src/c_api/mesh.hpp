#pragma once

#include <cstddef>
#include <cstdint>

#include "pierce/c/mesh.h"
#include "pierce/mesh.hpp"

namespace pierce::c {

/// A copy of a caller's vertices and triangles.
MeshData mesh_data(const float* positions, std::size_t vertex_count, const std::uint32_t* triangles,
                   std::size_t triangle_count);

static_assert(PIERCE_INSIDE_AUTOMATIC == static_cast<int>(Inside::automatic) &&
              PIERCE_INSIDE_CLOSED == static_cast<int>(Inside::closed) &&
              PIERCE_INSIDE_WINDING == static_cast<int>(Inside::winding) &&
              PIERCE_INSIDE_NONE == static_cast<int>(Inside::none));

}  // namespace pierce::c
