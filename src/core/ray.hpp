#pragma once

#include <cstdint>

#include "pierce/core/vec3.hpp"

namespace pierce {

inline constexpr std::uint32_t no_triangle = 0xffffffffu;
inline constexpr std::uint32_t no_vertex = 0xffffffffu;

/// A ray in the space of its target's positions: a rigid body's own space, the world for a deforming body.
struct Ray {
    Vec3d origin;
    Vec3d direction;                            ///< unit
    double t_max = 0;                           ///< [length]; negative: the ray hits nothing
    std::uint32_t target = 0;                   ///< body
    std::uint32_t excluded_vertex = no_vertex;  ///< triangles around this vertex are not hit
    double outward = 0;                         ///< [length] where nothing is left behind, look so far the other way
};

/// Where a ray comes from: vertex `vertex` of pair `pair`'s first (side 0) or second (side 1) body.
struct RaySource {
    std::uint32_t pair = 0;
    std::uint32_t side = 0;
    std::uint32_t vertex = 0;
};

/// What a tracer finds for a ray: the triangle, or no_triangle. Everything else follows from it in `classify`.
struct Hit {
    std::uint32_t triangle = no_triangle;
    bool predicted = false;  ///< found looking outward: the vertex has not entered yet

    friend bool operator==(const Hit&, const Hit&) = default;
};

}  // namespace pierce
