#pragma once

#include <limits>

#include "core/device/four.hpp"
#include "core/geometry/grid_boxes.hpp"
#include "core/geometry/quick_vec3.hpp"
#include "core/step/sheets/placed_triangle.hpp"
#include "core/step/sheets/slab.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"

#if defined(PIERCE_FOUR_LANES)

namespace pierce::stages {

/// How far triangles reach along the axes of a frame over the step, in float32, not less. It takes
/// a fifth of the time of double.
class FourReach {
public:
    /// `box`: of what is measured; heights are relative to its lower corner.
    FourReach(const SlabFrame& frame, const QuickBox& box) : origin_(FourVec3::all(box.lower)) {
        // Let u be half an ulp and s the largest coordinate. Coordinates are off by u s, the axis
        // by u, and a dot product by 3 u s times the sum of the axis's sizes more, which is below
        // 2: 9 u s in all, where quick_rounding takes 128. Products may also come near the smallest
        // float32.
        error_ = static_cast<double>(constants::quick_rounding * largest_of(box.upper - box.lower) +
                                     std::numeric_limits<float>::min());
        for (int k = 0; k < 3; ++k) axis_[k] = FourVec3::all(to_float(frame.axis[k]));
    }

    Box of(const PlacedTriangle& t) const {
        Four unused = 0;
        const FourVec3 some = FourVec3::gathered(&t.start[0], &t.start[1], &t.start[2], &t.end[0],
                                                 unused) -
                              origin_,
                       others = FourVec3::gathered(&t.end[0], &t.end[1], &t.end[2], &t.end[2],
                                                   unused) -
                                origin_;
        Box reach;
        for (int k = 0; k < 3; ++k) {
            const Four p = quick_dot(axis_[k], some), q = quick_dot(axis_[k], others);
            reach.lower[k] = static_cast<double>(least_of(min_of(p, q))) - error_;
            reach.upper[k] = -static_cast<double>(least_of(-max_of(p, q))) + error_;
        }
        return reach;
    }

private:
    FourVec3 origin_, axis_[3];
    double error_ = 0;
};

}  // namespace pierce::stages

#endif
