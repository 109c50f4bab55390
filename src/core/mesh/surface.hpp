#pragma once

#include "core/device/view.hpp"
#include "core/geometry/triangle_corners.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// How much of a triangle lies in other parts of its surface, where it does not separate inside
/// from outside.
enum class Cover : std::uint8_t { none, partly, wholly };

/// The surface a ray is traced against: triangles over positions that share the ray's space.
struct Surface {
    View<const Vec3f> positions;
    View<const Triangle> triangles;
    double touch = 0;                ///< [length] no ray against it has a larger touch tolerance
    View<const Cover> covered = {};  ///< per triangle; empty if no parts overlap, or if crossings
                                     ///< are looked at one by one

    PIERCE_HD TriangleCorners corners(std::uint32_t triangle) const {
        return {positions, triangles[triangle]};
    }
};

}  // namespace pierce
