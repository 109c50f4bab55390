#pragma once

#include <cstdint>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce::test {

/// A prism over a polygon of the x-y plane, which is seen counterclockwise and is cut into the
/// triangles `top`, from z = -1 to 1.
inline MeshData prism(const std::vector<Vec3f>& outline, const std::vector<Triangle>& top) {
    MeshData mesh;
    const auto n = static_cast<std::uint32_t>(outline.size());
    for (const float z : {-1.0f, 1.0f})
        for (const Vec3f p : outline) mesh.positions.push_back({p.x, p.y, z});
    for (const Triangle& t : top) {
        mesh.triangles.push_back({{t.vertex[0], t.vertex[2], t.vertex[1]}});
        mesh.triangles.push_back({{t.vertex[0] + n, t.vertex[1] + n, t.vertex[2] + n}});
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t j = (i + 1) % n;
        mesh.triangles.push_back({{i, j, j + n}});
        mesh.triangles.push_back({{i, j + n, i + n}});
    }
    return mesh;
}

}  // namespace pierce::test
