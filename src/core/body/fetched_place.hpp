#pragma once

#include "core/device/view.hpp"
#include "pierce/pose.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// Where a body is whose place is in device memory, as the host sees it.
struct FetchedPlace {
    Pose pose;                    ///< of a fixed or rigid body; else anything
    View<const Vec3f> positions;  ///< of a deforming one
    View<const Vec3f> start;      ///< where the step began; empty if that is not told
};

}  // namespace pierce
