#pragma once

#include "pierce/core/constants.hpp"
#include "pierce/core/mesh.hpp"

namespace pierce {

/// The unit outward normal of vertex `v`: its triangles' normals weighted by their angle at `v`, which makes its sign
/// right for inside tests (Baerentzen and Aanaes 2005). Zero if the triangles cancel or have no area.
PIERCE_HD inline Vec3d vertex_normal(const MeshView& mesh, View<const Vec3f> positions, std::uint32_t v) {
    Vec3d sum;
    for (std::uint32_t i = mesh.ring_offsets[v]; i < mesh.ring_offsets[v + 1]; ++i) {
        const Triangle& t = mesh.triangles[mesh.ring[i]];
        const int k = t.vertex[0] == v ? 0 : t.vertex[1] == v ? 1 : 2;
        const Vec3d apex = to_double(positions[v]);
        const Vec3d a = to_double(positions[t.vertex[(k + 1) % 3]]) - apex;
        const Vec3d b = to_double(positions[t.vertex[(k + 2) % 3]]) - apex;
        const Vec3d n = cross(a, b);
        const double lengths = std::sqrt(length_squared(a) * length_squared(b));
        if (!(lengths > 0)) continue;
        sum += arc_cosine(dot(a, b) / lengths) * normalized(n);
    }
    return length(sum) > constants::vanishing_normal ? normalized(sum) : Vec3d{};
}

}  // namespace pierce
