#pragma once

#include <optional>

#include "pierce/mesh.hpp"

class btCollisionShape;
class btSoftBody;

namespace pierce::bullet {

/// The triangles of a shape that is a triangle mesh, in its own frame, with its scale; nothing for
/// any other shape. Corners at the same place become one vertex.
std::optional<MeshData> mesh_of(const btCollisionShape& shape);

/// A soft body's nodes, where they are, and its faces.
MeshData mesh_of(const btSoftBody& soft);

}  // namespace pierce::bullet
