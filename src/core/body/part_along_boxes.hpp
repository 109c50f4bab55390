#pragma once

#include <cmath>
#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "pierce/min_max.hpp"
#include "pierce/parting.hpp"

namespace pierce {

/// [length] How far a body reaches along a direction of world space.
PIERCE_HD inline double highest(const BodyView& body, Vec3d u) {
    const Vec3d in_space = body.space.rotation.transposed() * u;
    double most = -INFINITY;
    for (std::uint32_t v = 0; v < body.mesh.positions.size; ++v)
        if (has_triangles(body.mesh, v))
            most = max_of(dot(in_space, to_double(body.positions[v])), most);
    return most + dot(u, body.space.origin);
}

/// Of the axes of both bodies' boxes, the direction along which body a leaves body b soonest. The
/// way along a direction is from the lowest point of a to the highest point of b.
PIERCE_HD inline Parting part_along_boxes(const BodyView& a, const BodyView& b) {
    Parting shortest{{}, INFINITY};
    for (int k = 0; k < 12; ++k) {
        const Matrix3 axes = (k < 6 ? a : b).fit.rotation.transposed();
        const Vec3d u = (k % 2 == 0 ? 1.0 : -1.0) * axes.row[k % 6 / 2];
        const double way = highest(b, u) + highest(a, -u);
        if (way < shortest.depth) shortest = {u, way};
    }
    return shortest;
}

}  // namespace pierce
