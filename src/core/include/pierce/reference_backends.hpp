#pragma once

#include <memory>

#include "pierce/backend.hpp"

namespace pierce {

/// One thread and brute force: slow, simple, and the definition of what every other backend must
/// answer.
std::unique_ptr<Backend> reference_backend();

/// One thread and our own trees, the ones that serve the GPU: for tests of theirs on any machine.
std::unique_ptr<Backend> bvh_backend();

}  // namespace pierce
