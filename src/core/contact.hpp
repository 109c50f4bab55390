#pragma once

#include <cstdint>

#include "pierce/core/float_rules.hpp"
#include "pierce/core/ids.hpp"
#include "pierce/core/vec3.hpp"

namespace pierce {

/// How a contact was found.
enum class Found : std::uint8_t {
    full,        ///< by a ray through the target's tree
    walk,        ///< by walking on from last step's triangle
    prediction,  ///< by a walk to a triangle it was predicted to enter through
};

/// Which of a contact's two bodies the ray started from.
enum class Side : std::uint8_t { a = 0, b = 1 };

/// A vertex of one body inside another, and the point where its inward ray leaves that other body.
/// Lengths in the caller's unit, everything in world space.
struct Contact {
    BodyId a, b;            ///< a < b by index
    Side source = Side::a;  ///< the body the vertex belongs to; the other one is the target
    bool grazing = false;   ///< the ray meets the triangle so flatly that the depth is uncertain
    Found found = Found::full;
    std::uint32_t vertex = 0;    ///< of the source
    std::uint32_t triangle = 0;  ///< of the target
    std::uint32_t age = 0;       ///< steps in a row this vertex has been in contact with this body; 0: new
    double barycentric[3] = {};  ///< of the target point in the triangle; sums to 1
    Vec3d point_a, point_b;      ///< on body a and on body b: the vertex and the target point
    Vec3d normal;                ///< unit, from a to b: the line of the ray, so (point_b - point_a) . normal = distance
    Vec3d face_normal;           ///< unit, outward, of the target triangle
    double distance = 0;         ///< signed, negative where the bodies overlap, zero where they touch

    double penetration_depth() const { return max_of(-distance, 0.0); }

    /// The same for the same vertex and pair in every step, unique within the pair.
    std::uint64_t feature() const { return (std::uint64_t{vertex} << 1) | static_cast<std::uint64_t>(source); }
};

}  // namespace pierce
