#pragma once

#include <filesystem>

#include "scenes/named/scene.hpp"

namespace pierce::scenes {

/// The folder of generated data: the build's folder, or PIERCE_DATA_DIR of the environment.
std::filesystem::path data_folder();

/// The Stanford bunny of 453 vertices and 902 triangles with its convex pieces, about 4 units tall,
/// in its principal frame. The build makes it from the mesh in Debian's libcgal-demo. Throws
/// InputError, naming the file, if the build did not make it.
SceneMesh bunny_mesh();

}  // namespace pierce::scenes
