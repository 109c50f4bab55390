#pragma once

#include <filesystem>

#include "pierce/mesh.hpp"

namespace pierce::scenes {

/// Reads a triangle mesh from an OBJ, PLY, STL or OFF file (mesh_readers.hpp), keeping the file's
/// vertex and triangle order; polygons are cut into fans, and a face with fewer than three corners
/// has no triangle. Throws InputError, naming the file, if it cannot be read, is cut short, or
/// holds no triangles. Numbers that are not finite, and indices of vertices that are not there, are
/// passed on: a Mesh refuses them, and check_mesh lists them. An index that is negative or beyond
/// 32 bits cannot be read.
MeshData read_mesh(const std::filesystem::path& file);

/// Writes an OBJ file with enough digits to read the same positions back. Throws InputError if it
/// cannot be written.
void write_obj(const std::filesystem::path& file, const MeshData& mesh);

}  // namespace pierce::scenes
