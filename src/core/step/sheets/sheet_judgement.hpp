#pragma once

#include <cstdint>

#include "pierce/contact.hpp"
#include "pierce/host_device.hpp"
#include "pierce/vec3.hpp"

namespace pierce::stages {

/// How two features stand at the end of the step.
struct alignas(16) SheetMeeting {
    double weight[2] = {};  ///< of the triangle's first two corners; for edges, the first is the
                            ///< place along the second edge
    double along = 0;       ///< place along the edge, or along the first of two edges
    Vec3d out;            ///< unit, world: where the first feature belongs, as seen from the second
    double distance = 0;  ///< [length] along `out`
    double time = 1;

    PIERCE_HD double weight_of(int corner) const {
        return corner < 2 ? weight[corner] : 1 - weight[0] - weight[1];
    }
};
static_assert(sizeof(SheetMeeting) == 64);

enum class Verdict : std::uint8_t { nothing, contact, undecided };

/// What is decided about two features.
struct Judgement {
    Verdict verdict = Verdict::nothing;
    Found found = Found::near;
    std::int8_t side = 0;  ///< where the vertex belongs, +1 on the side of the triangle's normal;
                           ///< of edges that touch, +1 on that of their cross product
    bool unknown = false;  ///< the way out is unknown
};
static_assert(sizeof(Judgement) == sizeof(std::uint32_t));

}  // namespace pierce::stages
