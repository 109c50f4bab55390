#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce {

/// Triangles across the gaps between borders that were cut alike.
struct GapSeams {
    std::vector<Triangle> triangles;
    double area = 0;
    /// Per vertex, one of those that lie next to each other on both sides of a gap.
    std::vector<std::uint32_t> cluster;
};

/// Sews borders whose vertices lie next to each other, as those of the sides of a box that were
/// made one by one: vertices of a border closer together than constants::seam_width times the
/// shortest edges at them belong together, and edges between the same of them face each other.
/// Where more than two borders meet, a hole between a few vertices of one cluster is left.
GapSeams gap_seams(std::span<const Vec3f> positions, std::span<const Triangle> triangles);

}  // namespace pierce
