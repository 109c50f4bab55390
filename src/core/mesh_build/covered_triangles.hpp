#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh/surface.hpp"
#include "core/mesh_build/covered_walls.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// Per triangle of a closed surface, whether it lies in other connected parts of the surface, or on
/// a face of one from outside; empty if no triangle does. Of faces that lie in one plane and face
/// the same way, none covers the other, and `twins`, which separate nothing, cover nothing. Only
/// triangles near the box around another part are looked at, so a surface of one part costs
/// nothing. That a part meets itself is not seen.
std::vector<Cover> covered_triangles(std::span<const Vec3f> positions,
                                     std::span<const Triangle> triangles,
                                     std::span<const Twins> twins, Workers& workers);

/// How many of the triangles are covered, wholly or partly.
std::uint32_t count_covered(std::span<const Cover> covered);

}  // namespace pierce
