// The gap between a segment and a triangle against their distance, measured place by place.
#include "core/step/edges/segment_gap.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/device/view.hpp"
#include "core/trace/closest_search.hpp"
#include "support/random.hpp"

namespace pierce::stages {
namespace {

/// The distance, to a few millionths: it is convex along the segment.
double distance_between(Vec3d a, Vec3d b, const Surface& surface) {
    double low = 0, high = 1;
    const auto at = [&](double t) { return distance_to(a + t * (b - a), surface, 0); };
    for (int i = 0; i < 60; ++i) {
        const double first = low + (high - low) / 3, second = high - (high - low) / 3;
        (at(first) < at(second) ? high : low) = at(first) < at(second) ? second : first;
    }
    return at(0.5 * (low + high));
}

TEST(SegmentGapTest, TheGapIsNeverMoreThanTheDistanceAndZeroOnlyWhereTheyMeet) {
    test::Random random(17);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    double sum_of_gaps = 0, sum_of_distances = 0;
    int meetings = 0;
    for (int i = 0; i < 20000; ++i) {
        // A third of the triangles are needles, a third are tiny.
        const double thin = i % 3 == 1 ? std::pow(10.0, -5 * random.uniform(0, 1)) : 1,
                     small = i % 3 == 2 ? std::pow(10.0, -5 * random.uniform(0, 1)) : 1;
        const Vec3d first = random.in_box(1), second = small * random.in_box(1),
                    third = thin * small * random.in_box(1) +
                            (thin < 1 ? random.uniform(0, 1) : 0) * second;
        const std::vector<Vec3f> positions{to_float(first), to_float(first + second),
                                           to_float(first + third)};
        const std::vector<Triangle> triangles{{{0, 1, 2}}};
        const Surface surface{view_of(std::as_const(positions)), view_of(std::as_const(triangles)),
                              0};
        const Vec3d middle = i % 2 == 0 ? random.in_box(1.5) : first + small * random.in_box(1.5);
        const Vec3d a = middle + random.in_box(0.7), b = middle + random.in_box(0.7);
        const double distance = distance_between(a, b, surface);
        const double gap = SegmentGaps(a, b, surface, {0, 0, 0, 0})[i % SegmentGaps::count];
        EXPECT_LE(gap, distance + 1e-6);
        // Rounding may leave nothing of a needle's gap.
        EXPECT_TRUE(gap > 0 || distance < 1e-3 || thin < 1);
        sum_of_gaps += gap;
        sum_of_distances += distance;
        meetings += distance < 1e-9;
    }
    EXPECT_GT(meetings, 30);
    EXPECT_GT(sum_of_gaps, 0.8 * sum_of_distances);
}

}  // namespace
}  // namespace pierce::stages
