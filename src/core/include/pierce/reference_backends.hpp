#pragma once

#include <memory>

#include "pierce/backend.hpp"
#include "pierce/tree_builder.hpp"

namespace pierce {

/// A backend of one thread and brute force: slow and simple. Its results define what every other
/// backend must answer.
std::unique_ptr<Backend> reference_backend();

/// A backend of one thread and our own trees, the same ones that the GPU uses. It allows tests of
/// those trees on any machine.
std::unique_ptr<Backend> bvh_backend(TreeOptions trees = {});

}  // namespace pierce
