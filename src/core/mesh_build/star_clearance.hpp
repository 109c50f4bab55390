#pragma once

#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/mesh_change.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Per vertex of the rest shape, a lower bound of the distance to the nearest triangle that does
/// not touch that vertex [length]; never more than the vertex's longest edge. A ray from the vertex
/// that is shorter than this cannot meet its own body. What `change` knows is taken from it; it may
/// be null.
std::vector<float> star_clearance(const MeshView& mesh, Workers& workers,
                                  const MeshChange* change = nullptr);

}  // namespace pierce
