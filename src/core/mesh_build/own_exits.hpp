#pragma once

#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh/mesh_view.hpp"

namespace pierce {

/// Per vertex of a closed mesh's rest shape, the length of its inward ray inside the mesh [length];
/// -1 where the ray does not start inside (rule R2), or has no direction. The ray leaves out the
/// triangles around its vertex.
std::vector<double> own_exits_of(const MeshView& mesh, Workers& workers);

}  // namespace pierce
