#pragma once

#include <memory>

#include "pierce/backend.hpp"

namespace pierce {

/// The CPU backend: Embree's trees and oneTBB's threads. At most `threads` threads, never more than
/// the machine has; zero takes all. Throws InputError if it is negative.
std::unique_ptr<Backend> embree_backend(int threads = 0);

/// The version of the Embree in use, as "3.13.5".
std::string embree_version();

}  // namespace pierce
