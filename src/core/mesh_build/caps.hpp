#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce {

/// A hole of a surface and what closes it.
struct Cap {
    std::vector<Triangle> triangles;  ///< between vertices of the surface
    std::uint32_t border_edges = 0;
    double area = 0;
    bool is_gap = false;  ///< the borders are the sides of a gap
};

/// Closes a surface: with the caps' triangles, as many triangles run through every edge one way as
/// the other. Gaps between borders that were cut alike are sewn up, together the last cap. Holes
/// follow one another along the borders, in order of their first vertices; two borders that are
/// nearer than constants::gap_width times `mean_edge` are closed together where that takes less
/// area, as two sides of a gap. A hole of up to constants::exact_cap_edges edges gets the
/// triangulation of the least area (Barequet and Sharir 1995), larger ones are closed ear by ear
/// until they are that small.
std::vector<Cap> caps_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                         double mean_edge);

}  // namespace pierce
