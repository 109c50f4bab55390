#pragma once

#include <cstddef>
#include <cstdint>

#include "pierce/mesh.hpp"

namespace pierce::test {

/// Splits the side of a triangle from corner `k` to the next one, `share` of the way along; a
/// triangle without area closes the gap. Unless the side runs along an axis, the new vertex is
/// beside it by rounding.
inline void add_t_junction(MeshData& mesh, std::size_t triangle, int k, double share) {
    const Triangle t = mesh.triangles[triangle];
    const std::uint32_t a = t.vertex[k], b = t.vertex[(k + 1) % 3], c = t.vertex[(k + 2) % 3];
    const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(to_float((1 - share) * to_double(mesh.positions[a]) +
                                      share * to_double(mesh.positions[b])));
    mesh.triangles[triangle] = {{a, middle, c}};
    mesh.triangles.push_back({{middle, b, c}});
    mesh.triangles.push_back({{a, b, middle}});
}

}  // namespace pierce::test
