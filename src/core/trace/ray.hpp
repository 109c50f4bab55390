#pragma once

#include <cstdint>

#include "core/trace/ridge.hpp"
#include "pierce/ids.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// A ray in the space of its target's positions: a rigid body's own space, the world for a
/// deforming body.
struct alignas(16) Ray {
    Vec3d origin;
    Vec3d direction;     ///< unit
    double t_max = 0;    ///< [length]; negative: the ray hits nothing
    double t_min = 0;    ///< [length] if positive, crossings up to here do not count, nor does a
                         ///< touch at the origin
    double outward = 0;  ///< [length] if the ray does not leave its target ahead, the search looks
                         ///< this far behind the origin
    double touch = 0;    ///< [length] crossings closer than this are one, and the origin touches a
                         ///< surface that is closer
    std::uint32_t target = 0;                            ///< body
    std::uint32_t excluded[2] = {no_vertex, no_vertex};  ///< triangles with both of these vertices
                                                         ///< are not hit; in a search for the
                                                         ///< closest triangle: two triangles that
                                                         ///< the way there must not lead into
    std::uint32_t padding = 0;
};

/// What a ray starts from.
enum class RayStart : std::uint8_t { vertex, chord };

/// Where a ray comes from: a vertex or chord of the first (side 0) or second (side 1) body of pair
/// `pair`.
struct RaySource {
    std::uint32_t pair = 0;
    std::uint32_t item = 0;  ///< a vertex of the body, or an entry of the step's list of chords
    std::uint8_t side = 0;
    RayStart start = RayStart::vertex;
    bool separates = false;  ///< its direction is not inward, but the one in which the two bodies
                             ///< separate soonest
    bool is_near = false;    ///< it is outside of the target, and near
};

/// A part of an edge inside the target, from one crossing of its surface to the next.
struct Chord {
    std::uint32_t edge = 0;
    std::uint32_t ordinal = 0;  ///< which of the edge's chords in this pair; if it is outside and
                                ///< near, the target's edge
    double along = 0;  ///< where its ray starts, from 0 at the edge's first vertex to 1 at the
                       ///< second: in its middle, or where it is closest to the ridge
    double skin = 0;   ///< [length] if the edge only touches the target: its ray does not count
                       ///< crossings up to here
    Ridge ridge;
    Vec3d begin, end;  ///< of a chord over a ridge, in the target's space
};

/// What a tracer finds for a ray: the triangle, or no_triangle. Everything else follows from the
/// triangle in `classify`.
struct alignas(8) Hit {
    std::uint32_t triangle = no_triangle;
    bool predicted = false;  ///< found looking outward: the vertex has not entered yet
    bool grazed = false;     ///< on its way the ray touched the surface and did not cross it
    std::uint8_t padding[2] = {};

    friend bool operator==(const Hit&, const Hit&) = default;
};

}  // namespace pierce
