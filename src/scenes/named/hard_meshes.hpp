#pragma once

#include "scenes/named/shapes.hpp"

/// The meshes of the hard cases.
namespace pierce::scenes::hard {

/// The unit cube.
MeshData cube();
/// The mesh scaled, then moved; `scale` and `by` must be such that no coordinate is rounded.
MeshData placed(MeshData mesh, float scale, Vec3f by);
/// Corners one from the origin.
MeshData octahedron();
/// The prism that the triangle a, b, c covers on its way along `along`. The triangle must be
/// clockwise seen against `along`.
MeshData prism(Vec3f a, Vec3f b, Vec3f c, Vec3f along);
/// A pyramid that stands on its apex: the base is a square around `base`, in the plane of z.
MeshData spike(Vec3f apex, Vec3f base, float half);
/// The cube's edge (0,0,0)-(1,0,0) is split in its middle on one side only; a triangle without area
/// fills the gap.
MeshData cube_with_filler();
/// Two tetrahedra, tip to tip in one vertex: the second is the first reflected in the tip, or in
/// the plane through it.
MeshData bowtie(bool in_plane);
/// A pyramid over a C whose apex stands over a corner of it: no direction from the apex is behind
/// all triangles around it.
MeshData pyramid_over_c();
/// A square sheet of four triangles around `center`, seen from above.
MeshData sheet(Vec3f center, float half, bool upward);
/// The cube with one triangle turned round, or left out.
MeshData cube_with_flipped_triangle();
MeshData cube_with_missing_triangle();
/// Edges 1/8 long.
MeshData small_cube_around(Vec3f center);

}  // namespace pierce::scenes::hard
