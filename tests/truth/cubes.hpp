#pragma once

#include <vector>

#include "scenes/named/shapes.hpp"

namespace pierce::truth {

inline std::vector<Vec3d> in_double(const std::vector<Vec3f>& positions) {
    std::vector<Vec3d> result;
    for (Vec3f p : positions) result.push_back(to_double(p));
    return result;
}

inline MeshData cube(double half) { return scenes::box({-half, -half, -half}, {half, half, half}); }

/// A cube of half size 1 without its last triangle.
inline MeshData open_cube() {
    MeshData mesh = cube(1);
    mesh.triangles.pop_back();
    return mesh;
}

}  // namespace pierce::truth
