#pragma once

#include <cstdint>

namespace pierce {

/// How trees are built.
enum class TreeBuilder : std::uint8_t {
    lbvh,   ///< split along a Morton curve: the fastest to build
    hlbvh,  ///< so at the bottom, by the surface area heuristic at the top
    trbvh,  ///< an LBVH, restructured: the fastest to trace
    ploc,   ///< neighbours on the curve join, the nearest first
};

}  // namespace pierce
