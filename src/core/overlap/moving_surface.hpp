#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/moving_point.hpp"
#include "pierce/box.hpp"
#include "pierce/mesh.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// Where a point is at a time from 0 to 1.
inline Vec3d at_time(const MovingPoint& p, double t) { return p.start + t * (p.end - p.start); }

/// A surface whose vertices move in straight lines from time 0 to time 1.
struct MovingSurface {
    std::vector<MovingPoint> points;
    std::span<const Triangle> triangles;

    /// Around the whole motion.
    Box box() const;
    /// Per vertex, the way its triangles face at time 0 or 1: `MovingPoint::start` or `end`.
    std::vector<Vec3d> normals(Vec3d MovingPoint::*at) const;
    /// The surface with all vertices moved inward by `depth` [length].
    MovingSurface inner(double depth) const;
    /// Which vertices and edges of each triangle are looked at with it, so that each is looked at
    /// once. Bits 0 to 2 are vertices, bits 3 to 5 the edges from them to the next ones.
    std::vector<std::uint8_t> own_features() const;
};

}  // namespace pierce
