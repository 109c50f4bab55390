#pragma once

#include <memory>

#include "pierce/backend.hpp"

namespace pierce::test {

/// One thread that runs the items of a stage in random order, and every step twice.
std::unique_ptr<Backend> shuffled_backend();

/// The standard library's parallel algorithms.
std::unique_ptr<Backend> parallel_backend();

}  // namespace pierce::test
