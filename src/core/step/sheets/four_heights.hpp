#pragma once

#include "core/device/four.hpp"
#include "core/geometry/grid_boxes.hpp"
#include "core/step/sheets/four_triangles.hpp"
#include "core/step/sheets/group_heights.hpp"
#include "core/step/sheets/placed_triangle.hpp"
#include "core/step/sheets/quick_triangle.hpp"
#include "core/step/sheets/slab.hpp"
#include "pierce/constants.hpp"

#if defined(PIERCE_FOUR_LANES)

namespace pierce::stages {

/// Compares how far triangles of two groups reach over the step along the normal of the second
/// group, four triangles of the first group at a time. Boxes of what is aslant overlap many others;
/// along the normal, layers are apart.
class FourHeights {
public:
    /// The boxes of both groups, and the second one's slab.
    FourHeights(const QuickBox& first, const QuickBox& second, const Slab& slab, float margin)
        : normal_(FourVec3::all(slab.axis[0])), origin_(FourVec3::all(second.lower)) {
        const Vec3f n = slab.axis[0];
        const float size = telling_size(
            quick_max(largest_of(second.upper - second.lower),
                      quick_max(largest_of(first.lower - second.lower),
                                largest_of(first.upper - second.lower))));
        sum_ = sum_of_sizes(n);
        // The normal is a unit vector up to rounding, and its square is less than that off. Heights
        // are rounded less often than what DriftingPair::along_middles() adds up.
        apart_ = margin * quick_max(1, quick_dot(n, n)) + made_up_along(n, size + margin);
    }

    /// For each of four triangles of the first group: a bit for each of the second group's that may
    /// be within the margin at some time.
    void near(const FourTriangles& triangles, const GroupHeights& others,
              std::uint32_t (&masks)[Four::count]) const {
        Four unused = 0, stray = 0;
        const Four p = quick_dot(normal_, triangles.corner(0, stray) - origin_),
                   q = quick_dot(normal_, triangles.corner(1, unused) - origin_),
                   r = quick_dot(normal_, triangles.corner(2, unused) - origin_),
                   way = quick_dot(normal_, triangles.drift(unused)),
                   off = Four(sum_) * stray + apart_;
        const Four low = min_of(p, min_of(q, r)) - max_of(way, 0) - off,
                   high = max_of(p, max_of(q, r)) - min_of(way, 0) + off;
        const auto share = [&](Four height) {
            return (height - Four(others.origin)) * Four(others.per_length);
        };
        const GridBoxes::StepRanges ranges(BoxSteps::at_shares(share(low), 1),
                                           BoxSteps::at_shares(share(high), 0));
        masks[0] = ranges.overlap<0>(others.lower, others.upper).top_bits();
        masks[1] = ranges.overlap<1>(others.lower, others.upper).top_bits();
        masks[2] = ranges.overlap<2>(others.lower, others.upper).top_bits();
        masks[3] = ranges.overlap<3>(others.lower, others.upper).top_bits();
    }

private:
    FourVec3 normal_, origin_;
    float sum_ = 0, apart_ = 0;
};

}  // namespace pierce::stages

#endif
