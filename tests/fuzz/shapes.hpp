#pragma once

#include "fuzz/choices.hpp"
#include "pierce/mesh.hpp"

namespace pierce::fuzz {

/// A small mesh, about one unit large: closed or open, simple or not, with or without defects. One
/// in a few dozen is refused by World::add_mesh().
MeshData any_mesh(Choices& choices);

/// A small closed mesh without any defect.
MeshData proper_mesh(Choices& choices);

}  // namespace pierce::fuzz
