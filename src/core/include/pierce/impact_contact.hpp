#pragma once

#include <cstdint>

#include "pierce/contact.hpp"
#include "pierce/ids.hpp"
#include "pierce/pose.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// Where a rigid body is going.
struct PoseAhead {
    BodyId body;
    Pose pose;
};

/// Two solids that are apart when a step begins, and where and when they first meet in it. A solver
/// that lets the two approach along the normal by no more than `gap` in the step keeps them apart.
struct ImpactContact {
    BodyId a, b;      ///< a < b by index
    double time = 0;  ///< [0..1] of the step; never after they meet. If the two touch when the
                      ///< step begins: when their depth reaches the touch tolerance
    Vec3d point;      ///< world space, at that time
    Vec3d normal;     ///< unit, from a to b: of the face, or across both edges
    double gap = 0;   ///< [length] of what meets, along the normal, when the step begins
    Vec3d start_a, start_b;              ///< world space: where what meets is then, on a and on b
    bool edges = false;                  ///< two edges meet; else a vertex and a face
    Side source = Side::a;               ///< the body of the vertex; Side::a for edges
    std::uint32_t vertex = 0;            ///< of the source, or the first one of its edge
    std::uint32_t edge_end = no_vertex;  ///< the second one of its edge
    std::uint32_t triangle = 0;          ///< of the other body: the face, or one at its edge
};

}  // namespace pierce
