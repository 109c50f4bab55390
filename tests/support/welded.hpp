#pragma once

#include <algorithm>
#include <cstdint>

#include "pierce/mesh.hpp"

namespace pierce::test {

/// The mesh with triangles that name the first vertex at each place; others have none left.
inline MeshData welded(MeshData mesh) {
    for (Triangle& t : mesh.triangles)
        for (std::uint32_t& v : t.vertex)
            v = static_cast<std::uint32_t>(std::ranges::find(mesh.positions, mesh.positions[v]) -
                                           mesh.positions.begin());
    return mesh;
}

}  // namespace pierce::test
