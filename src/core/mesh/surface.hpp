#pragma once

#include "core/device/view.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// The surface a ray is traced against: triangles over positions that share the ray's space.
struct Surface {
    View<const Vec3f> positions;
    View<const Triangle> triangles;
    double touch = 0;  ///< [length] no ray against it has a larger touch tolerance
};

}  // namespace pierce
