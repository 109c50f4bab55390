#pragma once

#include <span>
#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh_build/oriented_triangles.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Per patch: whether it separates inside from outside. Closed patches do, as solids of their own.
/// On the surface of a solid the winding number is 1/2, the mean of 1 and 0. On a wall within, both
/// sides are inside, and on a scrap that floats around, both are outside. Walls add to the winding
/// number on both sides of others, so where there may be some, those are judged first that can be
/// seen from outside.
std::vector<bool> separating_patches(std::span<const Vec3f> positions,
                                     const OrientedTriangles& surface, Workers& workers);

}  // namespace pierce
