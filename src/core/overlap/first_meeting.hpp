#pragma once

#include <cstdint>
#include <vector>

#include "core/overlap/moving_surface.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// When two surfaces that are apart at time 0 first meet: a vertex and a face, or two edges.
struct FirstMeeting {
    double time = 0;
    Vec3d place;         ///< where they meet
    Vec3d normal;        ///< unit, from the first surface to the second
    double gap = 0;      ///< [length] of what meets at time 0, along the normal
    Vec3d start[2];      ///< where it is at time 0, on the first surface and on the second
    bool edges = false;  ///< two edges meet; else a vertex and a face
    bool vertex_of_second = false;
    std::uint32_t vertex = 0;    ///< the vertex, or the first one of the first surface's edge
    std::uint32_t edge_end = 0;  ///< of that edge
    std::uint32_t triangle = 0;  ///< the face, or one at the second surface's edge
};

/// [length] The touch tolerance of two surfaces where they begin: of the larger one of its two
/// directions, as contacts have it (docs/numbers.md).
double touch_at_start(const MovingSurface& first, const MovingSurface& second);

/// The first meeting of two surfaces, nothing if they do not meet. No meeting is missed
/// (core/geometry/continuous.hpp) but of places that touch at time 0 and are not deeper than the
/// touch tolerance later. It is followed by the first meetings of other vertices, far from each
/// other as they begin, up to `most` in all.
std::vector<FirstMeeting> first_meetings(const MovingSurface& first, const MovingSurface& second,
                                         std::uint32_t most);

}  // namespace pierce
