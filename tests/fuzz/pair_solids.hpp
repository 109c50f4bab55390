#pragma once

#include "fuzz/choices.hpp"
#include "pierce/mesh.hpp"
#include "pierce/pose.hpp"

namespace pierce::fuzz {

/// A closed mesh of 4 to 200 triangles that does not meet itself and faces outward: convex or not,
/// of one part or several, with a cavity, stretched and turned.
MeshData random_solid(Choices& choices);

/// A rotation without a preferred axis, near enough.
Quaternion random_rotation(Choices& choices);

/// How far apart two opposite corners of the mesh's box are [length].
double extent_of(const MeshData& mesh);

}  // namespace pierce::fuzz
