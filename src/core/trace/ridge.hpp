#pragma once

#include <cstdint>

#include "core/mesh/surface.hpp"
#include "pierce/ids.hpp"
#include "pierce/mesh.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// The edge that two triangles of a target share: the one opposite to a corner of one of them.
struct Ridge {
    std::uint32_t triangle = no_triangle;  ///< no_triangle: there is none
    std::uint32_t corner = 0;

    PIERCE_HD bool exists() const { return triangle != no_triangle; }
};

/// The ends of a ridge that exists.
struct RidgeEnds {
    Vec3d from, to;

    PIERCE_HD RidgeEnds(const Surface& surface, const Ridge& ridge) {
        const Triangle& t = surface.triangles[ridge.triangle];
        from = to_double(surface.positions[t.vertex[ridge.corner == 2 ? 0 : ridge.corner + 1]]);
        to = to_double(surface.positions[t.vertex[ridge.corner == 0 ? 2 : ridge.corner - 1]]);
    }
};

}  // namespace pierce
