#pragma once

#include <span>
#include <vector>

#include "core/overlap/exact_sides.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// A closed surface on a grid.
struct GridSurface {
    std::span<const GridPoint> points;
    std::span<const Triangle> triangles;
};

/// A piece of the outline of a part, with the part at its left; it counts `weight` times.
struct OutlinePiece {
    double weight = 1;
    Vec3d from, to;
};

/// The part of a triangle that is inside another surface. Where that surface covers a place several
/// times, the place counts as often. Places are from FaceParts::origin.
struct FacePart {
    std::uint32_t triangle = 0;
    double area = 0;  ///< zero or a little less only by rounding
    Vec3d normal;     ///< of the triangle, unit
    Vec3d moment;     ///< the integral of the place
    Vec3d squares;    ///< the integral of x x, y y and z z
    std::vector<OutlinePiece> outline;
};

/// What two closed surfaces have in common, by their parts inside each other.
struct FaceParts {
    Vec3d origin;  ///< from the middle of the grid: one of the places that they have in common, so
                   ///< that integrals over small parts keep their digits
    std::vector<FacePart> of[2];                ///< of the first surface and of the second
    std::vector<std::uint32_t> vertices_in[2];  ///< their vertices inside the respective other one
};

/// What a part adds to the volume that two surfaces have in common, by the divergence theorem.
inline double volume_of(const FacePart& part) { return dot(part.moment, part.normal) / 3; }

/// Finds the parts of two surfaces that are inside each other. Edges are cut where they go through
/// triangles, and every cut is known without rounding, so the parts' outlines close in any
/// arrangement of the surfaces; where a cut is has the rounding of doubles. Takes n log n and the
/// number of pairs of boxes of edges and triangles that overlap.
FaceParts find_face_parts(const Grid& grid, const GridSurface& first, const GridSurface& second);

}  // namespace pierce
