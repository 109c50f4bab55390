#pragma once

#include <cstdint>

namespace pierce {

/// How trees are built.
enum class TreeBuilder : std::uint8_t {
    lbvh,   ///< split along a Morton curve: the fastest to build
    hlbvh,  ///< split along a Morton curve at the bottom, and by the surface area heuristic at the
            ///< top
    trbvh,  ///< a restructured LBVH: the fastest to trace
    ploc,   ///< neighbours on the Morton curve are joined, the nearest first
};

/// Throws InputError for a value without a meaning.
void check_tree_builder(TreeBuilder builder);

/// How trees of our own are made and kept.
struct TreeOptions {
    TreeBuilder builder = TreeBuilder::lbvh;
    bool rebuild = false;  ///< every step builds all trees anew; else they are refitted, and built
                           ///< anew when they have decayed
};

}  // namespace pierce
