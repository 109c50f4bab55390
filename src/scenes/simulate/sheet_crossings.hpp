#pragma once

#include <span>

#include "pierce/mesh.hpp"

namespace pierce::scenes {

/// Where surfaces go through each other at one moment, whatever came before.
struct SurfaceCrossings {
    std::uint32_t count = 0;  ///< edges through triangles
    /// The deepest of them [length]: of each, the smaller distance of the edge's two ends from the
    /// triangle's plane.
    double depth = 0;
};

/// Edges of a surface through triangles of its own that they share no vertex with. Touching is no
/// crossing; double arithmetic.
SurfaceCrossings self_crossings(std::span<const Triangle> triangles,
                                std::span<const Vec3f> positions);

/// Edges of either surface through triangles of the other.
SurfaceCrossings crossings(std::span<const Triangle> triangles, std::span<const Vec3f> positions,
                           std::span<const Triangle> other_triangles,
                           std::span<const Vec3f> other_positions);

}  // namespace pierce::scenes
