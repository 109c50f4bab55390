#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "pierce/backend.hpp"

namespace pierce {

/// More parts than this are refused.
inline constexpr std::uint32_t most_parts = 1024;

/// One of the backends that share a world's bodies.
struct Part {
    std::unique_ptr<Backend> backend;
    double share = 1;  ///< of the work, relative to the other parts' shares
};

/// A backend that spreads a world over several others, each of which steps in its own thread: the
/// space that bodies fill is cut into parts with the wanted shares of all triangles, and is cut
/// anew when bodies have mixed. Each part sees its own bodies and those that are near, and looks at
/// the pairs whose first moving body it owns. Contacts are those of one backend, bit for bit
/// (docs/scale.md). Some parts may run on a device and some on the host; places in device memory
/// need parts that all run there. World::plan() says what runs where. Throws InputError if there
/// are no parts or more than most_parts, or if a share is not positive.
std::unique_ptr<Backend> partitioned_backend(std::vector<Part> parts);

/// The same with equal parts, each made with its part of the threads, at least one; `threads`: 0
/// stands for one per processor, and a negative number goes to `make` as it is.
std::unique_ptr<Backend> partitioned_backend(
    std::uint32_t parts, int threads,
    const std::function<std::unique_ptr<Backend>(int threads)>& make);

/// Devices that share a world with the host, which gets `share` of the work of one of them.
std::unique_ptr<Backend> partitioned_backend(std::vector<std::unique_ptr<Backend>> devices,
                                             std::unique_ptr<Backend> host, double share);

}  // namespace pierce
