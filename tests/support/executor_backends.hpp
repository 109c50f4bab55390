#pragma once

#include <cstdint>
#include <memory>

#include "pierce/backend.hpp"

namespace pierce::test {

/// One thread that runs the items of a stage in random order, and every step twice.
std::unique_ptr<Backend> shuffled_backend();

/// The same, every step once; it throws std::bad_alloc when it has made `lists_left` lists.
std::unique_ptr<Backend> backend_with_little_memory(std::uint32_t& lists_left);

/// The standard library's parallel algorithms.
std::unique_ptr<Backend> parallel_backend();

}  // namespace pierce::test
