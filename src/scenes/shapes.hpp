#pragma once

#include <cstdint>

#include "pierce/core/mesh.hpp"

namespace pierce::scenes {

/// A torus around the z axis: `around` segments about the axis, `across` about the tube; around * across vertices.
MeshData torus(double major_radius, double minor_radius, std::uint32_t around, std::uint32_t across);

/// An axis-aligned box of 8 vertices and 12 triangles.
MeshData box(Vec3d lower, Vec3d upper);

/// A sphere around the origin: an icosahedron split `levels` times, 20 * 4^levels triangles.
MeshData sphere(double radius, int levels);

}  // namespace pierce::scenes
