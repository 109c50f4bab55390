#pragma once

#include <cstdint>

#include "pierce/ids.hpp"
#include "pierce/pose.hpp"

/// What is remembered of edges near another body's surface. Worlds are saved without it.
namespace pierce {

/// Stands for any triangles: it is not known which. How many, the edge's proof says.
inline constexpr std::uint32_t some_triangle = no_triangle - 1;

/// The triangles near an edge: 44 bytes. All others are so far away that they stay away until the
/// odometer reaches `until`, and as long as both ends of the edge are closer than `way_left`
/// [length] to where the pair's anchor has them.
struct NearTriangles {
    static constexpr std::uint32_t most = 8;

    float until = -1, way_left = -1;  ///< negative: they are not known
    std::uint32_t count = 0;
    std::uint32_t triangle[most] = {};
};

/// An edge of a directed pair's source that is near the target's surface: 64 bytes.
struct alignas(16) NearEdge {
    std::uint32_t directed = 0;
    std::uint32_t edge = 0;
    float expiry = 0;    ///< the edge crosses one triangle at most until the odometer reaches this
    float way_left = 0;  ///< [length] and as long as both its ends are closer than this to where
                         ///< the pair's anchor has them
    std::uint32_t crosses = some_triangle;  ///< the triangle that it may cross until then; or
                                            ///< some_triangle, if it is not known which
    NearTriangles triangles;
};
static_assert(sizeof(NearEdge) == 64);

/// The near edges of a directed pair.
struct NearEdgesOfPair {
    Frame anchor;      ///< the source's space to the target's when they were found
    float expiry = 0;  ///< all other edges are away from the target's surface until the odometer
                       ///< reaches this
    std::uint32_t first = 0, count = 0;
    std::uint16_t is_kept = 0;  ///< 1: they are those of the last step
    std::uint16_t unasked = 0;  ///< for how many steps nobody has asked for them
};

}  // namespace pierce
