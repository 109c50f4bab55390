#pragma once

#include <span>
#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh_build/oriented_triangles.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Turns open patches that show clearly more of their backs than of their fronts to somebody far
/// away (Takayama et al. 2014). Others, and those that cannot be seen, stay. A patch is open if
/// some of its edges lack a triangle of its own, or have one too many. Returns which patches were
/// turned.
std::vector<bool> turn_seen_sides_outward(std::span<const Vec3f> positions,
                                          OrientedTriangles& surface, Workers& workers);

}  // namespace pierce
