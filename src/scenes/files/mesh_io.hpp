#pragma once

#include <filesystem>

#include "pierce/mesh.hpp"

namespace pierce::scenes {

/// Reads a triangle mesh from an OBJ, PLY, STL or OFF file, keeping the file's vertex and triangle
/// order; polygons are cut into fans. Throws InputError, naming the file, if it cannot be read, is
/// cut short, or holds no triangles. Numbers and indices are passed on unchanged, also NaN and
/// indices out of range: a Mesh refuses them, and check_mesh lists them.
MeshData read_mesh(const std::filesystem::path& file);

/// Writes an OBJ file with enough digits to read the same positions back.
void write_obj(const std::filesystem::path& file, const MeshData& mesh);

}  // namespace pierce::scenes
