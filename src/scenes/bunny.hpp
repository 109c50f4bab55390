#pragma once

#include "scenes/scene.hpp"

namespace pierce::scenes {

/// The Stanford bunny of 453 vertices and 902 triangles with its convex pieces, about 4 units tall,
/// in its principal frame. Made when the project is built from the mesh in Debian's libcgal-demo.
/// Throws InputError, naming the file, if it was not.
SceneMesh bunny_mesh();

}  // namespace pierce::scenes
