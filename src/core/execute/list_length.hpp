#pragma once

#include <cstdint>
#include <limits>
#include <stdexcept>

namespace pierce {

/// The length of a list. Throws std::length_error for 2^32 things or more.
inline std::uint32_t list_length(std::uint64_t things) {
    if (things > std::numeric_limits<std::uint32_t>::max())
        throw std::length_error("a step would list 2^32 things or more");
    return static_cast<std::uint32_t>(things);
}

}  // namespace pierce
