#pragma once

#include "pierce/core/float_rules.hpp"
#include "pierce/core/quick_vec3.hpp"

/// How far things of sheets reach along a direction during a step, as float32 sees it.
namespace pierce::stages {

/// A point during the step, float32, relative to some place near it.
struct QuickPoint {
    Vec3f start, end;
};

/// How far some points reach along a direction, at the start of the step and at its end.
struct Reach {
    float low[2] = {}, high[2] = {};

    Reach() = default;
    template <int count>
    PIERCE_HD Reach(Vec3f n, const QuickPoint (&points)[count]) {
        for (int k = 0; k < count; ++k) {
            const float at[2] = {quick_dot(n, points[k].start), quick_dot(n, points[k].end)};
            for (int when = 0; when < 2; ++when) {
                low[when] = k == 0 ? at[when] : quick_min(at[when], low[when]);
                high[when] = k == 0 ? at[when] : quick_max(at[when], high[when]);
            }
        }
    }
};

}  // namespace pierce::stages
