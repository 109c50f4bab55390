#pragma once

#include <cstdint>

#include "core/device/view.hpp"
#include "pierce/mesh.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// Where the corners of a triangle are.
struct TriangleCorners {
    Vec3d a, b, c;

    PIERCE_HD TriangleCorners(View<const Vec3f> positions, const Triangle& t)
        : a(to_double(positions[t.vertex[0]])),
          b(to_double(positions[t.vertex[1]])),
          c(to_double(positions[t.vertex[2]])) {}

    /// The normal, as long as twice the area.
    PIERCE_HD Vec3d normal() const { return cross(b - a, c - a); }
};

}  // namespace pierce
