#pragma once

#include <memory>

#include "pierce/backend.hpp"

namespace pierce {

/// The CPU backend: Embree's trees and oneTBB's threads. It uses at most `threads` threads, never
/// more than the machine has; zero means all. Throws InputError if `threads` is negative.
std::unique_ptr<Backend> embree_backend(int threads = 0);

/// The version of Embree in use, for example "3.13.5".
std::string embree_version();

}  // namespace pierce
