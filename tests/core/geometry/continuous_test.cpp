// Vertices that meet faces and edges that meet edges during a step: cases with known answers, and
// closest points.
#include "core/geometry/continuous.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/geometry/closest_point.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using test::Random;

MovingPoint still(Vec3d p) { return {p, p}; }
MovingPoint moving(Vec3d p, Vec3d by) { return {p, p + by}; }

TEST(ContinuousTest, BulletThroughAPlate) {
    const MovingPoint bullet{{0.1, 0.2, 1}, {0.1, 0.2, -1}};
    Impact impact;
    ASSERT_TRUE(vertex_meets_face(bullet, still({-1, -1, 0.005}), still({2, -1, 0.005}),
                                  still({-1, 2, 0.005}), impact));
    EXPECT_LE(impact.time, 0.4975);
    EXPECT_NEAR(impact.time, 0.4975, 3 * constants::meeting_tolerance);
    EXPECT_NEAR(impact.u, 1.1 / 3, 1e-6);
    EXPECT_NEAR(impact.v, 1.2 / 3, 1e-6);
}

TEST(ContinuousTest, LayersThatMoveTogetherDoNotMeet) {
    const Vec3d by{0, 0, 0.2};
    Impact impact;
    EXPECT_FALSE(vertex_meets_face(moving({0.3, 0.3, 0}, by), moving({0, 0, 0.1}, by),
                                   moving({1, 0, 0.1}, by), moving({0, 1, 0.1}, by), impact));
    EXPECT_FALSE(edges_meet(moving({0, 0.5, 0}, by), moving({1, 0.5, 0}, by),
                            moving({0.5, 0, 0.1}, by), moving({0.5, 1, 0.1}, by), impact));
    EXPECT_TRUE(vertex_meets_face(moving({0.3, 0.3, 0}, by), still({0, 0, 0.1}), still({1, 0, 0.1}),
                                  still({0, 1, 0.1}), impact));
    EXPECT_NEAR(impact.time, 0.5, 1e-5);
}

TEST(ContinuousTest, CrossedEdgesMeetHalfWay) {
    Impact impact;
    ASSERT_TRUE(edges_meet(moving({-1, 0, 1}, {0, 0, -2}), moving({3, 0, 1}, {0, 0, -2}),
                           still({0, -1, 0}), still({0, 1, 0}), impact));
    EXPECT_LE(impact.time, 0.5);
    EXPECT_NEAR(impact.time, 0.5, 1e-5);
    EXPECT_NEAR(impact.u, 0.25, 1e-6);
    EXPECT_NEAR(impact.v, 0.5, 1e-6);
    EXPECT_FALSE(edges_meet(moving({-1, 0, 1}, {0, 0, -0.99}), moving({3, 0, 1}, {0, 0, -0.99}),
                            still({0, -1, 0}), still({0, 1, 0}), impact));
}

TEST(ContinuousTest, TouchingAtTheEndsOfTheStepCounts) {
    const MovingPoint a = still({0, 0, 0}), b = still({1, 0, 0}), c = still({0, 1, 0});
    Impact impact;
    EXPECT_TRUE(vertex_meets_face({{0.25, 0.25, 1}, {0.25, 0.25, 0}}, a, b, c, impact));
    EXPECT_NEAR(impact.time, 1, 1e-5);
    for (Vec3d p : {Vec3d{0.25, 0.25, 0}, Vec3d{0, 0, 0}, Vec3d{0.5, 0.5, 0}, Vec3d{0, 0.75, 0}}) {
        EXPECT_TRUE(vertex_meets_face({p, p + Vec3d{0, 0, 1}}, a, b, c, impact));
        EXPECT_EQ(impact.time, 0);
        EXPECT_TRUE(vertex_meets_face(still(p), a, b, c, impact));
        EXPECT_EQ(impact.time, 0);
    }
    EXPECT_FALSE(vertex_meets_face(still({0.25, 0.25, 1e-5}), a, b, c, impact));
    EXPECT_FALSE(vertex_meets_face(still({0.6, 0.6, 0}), a, b, c, impact));
    EXPECT_TRUE(vertex_meets_face({{-1, 0.25, 0}, {2, 0.25, 0}}, a, b, c, impact))
        << "within the plane";
    EXPECT_NEAR(impact.time, 1.0 / 3, 1e-5);
}

TEST(ContinuousTest, PointsAndEdgesWithoutLength) {
    const MovingPoint origin = still({0, 0, 0}), passing{{-1, 0, 0}, {1, 0, 0}},
                      missing{{-1, 0, 0.001}, {1, 0, 0.001}};
    Impact impact;
    EXPECT_TRUE(vertex_meets_face(origin, origin, origin, origin, impact));
    EXPECT_EQ(impact.time, 0);
    EXPECT_TRUE(edges_meet(origin, origin, passing, passing, impact));
    EXPECT_NEAR(impact.time, 0.5, 1e-5);
    EXPECT_FALSE(edges_meet(origin, origin, missing, missing, impact));
    EXPECT_TRUE(
        vertex_meets_face(passing, still({0, -1, 0}), still({0, 1, 0}), still({0, 3, 0}), impact));
    EXPECT_FALSE(
        vertex_meets_face(missing, still({0, -1, 0}), still({0, 1, 0}), still({0, 3, 0}), impact));
}

TEST(ContinuousTest, AFaceThatTurnsOverSweepsTheVertex) {
    // At time 1/2 the face is the segment from (0,0,0) to (0,1,0); it turns about it through the
    // point.
    const MovingPoint a = still({0, 0, 0}), b{{1, 0, 1}, {-1, 0, 1}}, c = still({0, 1, 0});
    Impact impact;
    ASSERT_TRUE(vertex_meets_face(still({0, 0.25, 0.5}), a, b, c, impact));
    EXPECT_LE(impact.time, 0.5);
    EXPECT_NEAR(impact.time, 0.5, 1e-5);
    EXPECT_FALSE(vertex_meets_face(still({0, 0.25, 0.8}), a, b, c, impact));
}

TEST(ContinuousTest, NumbersThatAreNoneMeet) {
    Impact impact;
    EXPECT_TRUE(vertex_meets_face(still({NAN, 0, 0}), still({0, 0, 0}), still({1, 0, 0}),
                                  still({0, 1, 0}), impact));
    EXPECT_TRUE(edges_meet(still({0, 0, 1}), still({INFINITY, 0, 1}), still({0, -1, 0}),
                           still({1, 1, 0}), impact));
}

TEST(ClosestPointsOfSegmentsTest, NoSampledPlaceIsCloser) {
    Random random(1);
    SCOPED_TRACE(testing::Message() << "seed " << random.seed());
    for (int round = 0; round < 2000; ++round) {
        const double scale = std::ldexp(1.0, random.integer(-20, 20));
        Vec3d at[4];
        for (Vec3d& p : at) p = scale * random.in_box(1);
        switch (random.integer(0, 5)) {
            case 0:
                at[3] = at[2] + random.uniform(-2, 2) * (at[1] - at[0]);
                break;  // parallel
            case 1:
                at[3] = at[2] + (at[1] - at[0]) +
                        scale * std::ldexp(1.0, -random.integer(1, 50)) * random.in_box(1);
                break;
            case 2:
                at[1] = at[0];
                break;
            case 3:
                at[1] = at[0], at[3] = at[2];
                break;
            case 4:  // on one line
                at[2] = at[0] + random.uniform(-2, 2) * (at[1] - at[0]);
                at[3] = at[0] + random.uniform(-2, 2) * (at[1] - at[0]);
                break;
            default:
                break;
        }
        const auto apart = [&](double s, double t) {
            return length(at[0] + s * (at[1] - at[0]) - at[2] - t * (at[3] - at[2]));
        };
        const SegmentPlaces places = closest_points_of_segments(at[0], at[1], at[2], at[3]);
        ASSERT_TRUE(places.first >= 0 && places.first <= 1 && places.second >= 0 &&
                    places.second <= 1);
        const double found = apart(places.first, places.second);
        for (int i = 0; i <= 40; ++i)
            for (int j = 0; j <= 40; ++j) {
                const double s = i / 40.0, t = j / 40.0;
                ASSERT_LE(found, apart(s, t) + 1e-14 * scale)
                    << "round " << round << " at " << s << ", " << t;
            }
        ASSERT_LE(found, segment_distance(at[0], at[1], at[2], at[3]) + 1e-14 * scale);
    }
}

TEST(ClosestPlaceOnTriangleTest, NoSampledPlaceIsCloser) {
    Random random(2);
    SCOPED_TRACE(testing::Message() << "seed " << random.seed());
    for (int round = 0; round < 2000; ++round) {
        Vec3d at[4];
        for (Vec3d& p : at) p = random.in_box(1);
        switch (random.integer(0, 4)) {
            case 0:
                at[3] = at[1] + random.uniform(-2, 2) * (at[2] - at[1]);
                break;
            case 1:
                at[2] = at[1];
                break;
            case 2:
                at[1] = at[2] = at[3];
                break;
            default:
                break;
        }
        const auto apart = [&](double u, double v) {
            return length(at[0] - at[1] - u * (at[2] - at[1]) - v * (at[3] - at[1]));
        };
        const TrianglePlace place = closest_place_on_triangle(at[0], at[1], at[2], at[3]);
        ASSERT_TRUE(place.second >= 0 && place.third >= 0 &&
                    place.second + place.third <= 1 + 1e-15);
        const double found = apart(place.second, place.third);
        for (int i = 0; i <= 40; ++i)
            for (int j = 0; i + j <= 40; ++j)
                ASSERT_LE(found, apart(i / 40.0, j / 40.0) + 1e-8) << "round " << round;
    }
}

}  // namespace
}  // namespace pierce
