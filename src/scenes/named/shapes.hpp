#pragma once

#include <cstdint>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce::scenes {

/// A torus around the z axis: `around` segments about the axis, `across` about the tube; around *
/// across vertices.
MeshData torus(double major_radius, double minor_radius, std::uint32_t around,
               std::uint32_t across);

/// An axis-aligned box of 8 vertices and 12 triangles.
MeshData box(Vec3d lower, Vec3d upper);

/// A sphere around the origin: an icosahedron split `levels` times, 20 * 4^levels triangles.
MeshData sphere(double radius, int levels);

/// The same with edges of the icosahedron split into so many parts: 20 * parts^2 triangles.
MeshData geodesic_sphere(double radius, std::uint32_t parts);

/// A flat sheet at z = 0 around the origin: `along` by `across` vertices in rows along x, each quad
/// is cut in two, every other one along its other diagonal, so that no direction is preferred.
MeshData grid(double width, double depth, std::uint32_t along, std::uint32_t across);

/// An open tube around the z axis: `rings` rings of `around` vertices, ring after ring, from
/// -height / 2 to height / 2.
MeshData tube(double radius, double height, std::uint32_t around, std::uint32_t rings);

/// A closed capsule along the x axis: a cylinder of half the length `half_length` and half spheres
/// at its ends.
MeshData capsule(double radius, double half_length, std::uint32_t around, std::uint32_t rings);

/// Two meshes as one: the second mesh's vertices and triangles come after the first's.
MeshData joined(MeshData first, const MeshData& second);

/// All positions shifted by `by`.
std::vector<Vec3f> moved(std::vector<Vec3f> positions, Vec3f by);

}  // namespace pierce::scenes
