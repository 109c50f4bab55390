#pragma once

#include <cstdint>
#include <optional>

#include "pierce/mesh.hpp"

class btCollisionShape;
class btSoftBody;

namespace pierce::bullet {

bool is_triangle_mesh(const btCollisionShape& shape);

/// A number that tells triangle meshes apart: a hash of how large their arrays are, of where these
/// lie and of a few of their vertices and triangles. The same for all shapes of other types.
std::uint64_t mark_of(const btCollisionShape& shape);

/// The triangles of a shape that is a triangle mesh, in its own frame, with its scale; nothing for
/// any other shape. Corners at the same place become one vertex. A mesh that faces inward as a
/// whole, as a mirrored one does, is turned.
std::optional<MeshData> mesh_of(const btCollisionShape& shape);

/// [length^3] Negative if a closed mesh faces inward.
double volume_of(const Mesh& mesh);

/// A soft body's nodes, where they are, and its faces.
MeshData mesh_of(const btSoftBody& soft);

}  // namespace pierce::bullet
