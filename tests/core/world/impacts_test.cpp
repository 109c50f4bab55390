// First meetings of fast bodies, against overlaps at many times of the step.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/hard_cases.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

const Quaternion upright{0, 0, 0, 1};

std::vector<Vec3f> between(const std::vector<Vec3f>& start, const std::vector<Vec3f>& end,
                           double t) {
    std::vector<Vec3f> result;
    for (std::size_t v = 0; v < start.size(); ++v)
        result.push_back(
            to_float(to_double(start[v]) + t * (to_double(end[v]) - to_double(start[v]))));
    return result;
}

TEST(ImpactsTest, ABulletThroughAPlate) {
    const auto cases = scenes::hard_cases();
    const auto bullet = std::ranges::find(cases, "bullet_through_plate", &scenes::HardCase::name);
    ASSERT_NE(bullet, cases.end());
    World world;
    const MeshData shape = scenes::box({-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01});
    const BodyId plate = world.add_fixed_body(world.add_mesh("plate", bullet->rays[0].mesh));
    const BodyId body = world.add_rigid_body(world.add_mesh("bullet", shape));
    world.set_motion(body, {{0, 0, 1}, upright}, {{0, 0, -1}, upright});
    const auto impacts = world.impacts();
    ASSERT_EQ(impacts.size(), 1u);
    EXPECT_EQ(impacts[0].a, plate);
    EXPECT_EQ(impacts[0].b, body);
    const double way = 1 - 0.01 - 0.005;
    EXPECT_NEAR(impacts[0].time, way / 2, 1e-6);
    EXPECT_NEAR(impacts[0].gap, way, 1e-6);
    EXPECT_NEAR(impacts[0].normal.z, 1, 1e-9) << "from the plate to the bullet";
    EXPECT_NEAR(impacts[0].point.z, 0.005, 1e-6);
    world.detect();
    EXPECT_TRUE(world.contacts().empty()) << "a single place does not answer it";
    EXPECT_TRUE(world.impacts().empty()) << "it has not moved since";
}

TEST(ImpactsTest, ABoxThatLandsFlatIsHeldAtItsCorners) {
    World world;
    const BodyId plate = world.add_fixed_body(
        world.add_mesh("plate", scenes::box({-2, -2, -0.1f}, {2, 2, 0})));
    const BodyId body = world.add_rigid_body(
        world.add_mesh("box", scenes::box({-0.5f, -0.5f, 0}, {0.5f, 0.5f, 1})),
        {{0, 0, 1}, upright});
    const PoseAhead ahead[] = {{body, {{0, 0, -3}, upright}}};
    const auto first = world.impacts_ahead(ahead), most = world.impacts_ahead(ahead, 8);
    ASSERT_EQ(first.size(), 1u);
    ASSERT_EQ(most.size(), 4u) << "the upper corners meet it where the lower ones have";
    Box corners;
    for (std::size_t i = 0; i < most.size(); ++i) {
        EXPECT_EQ(most[i].a, plate);
        EXPECT_GE(most[i].time, most[0].time);
        EXPECT_NEAR(dot(most[i].start_b - most[i].start_a, most[i].normal), most[i].gap, 1e-9);
        EXPECT_NEAR(most[i].gap, most[i].start_b.z, 1e-6);
        corners.extend(most[i].start_b);
    }
    EXPECT_NEAR(length(corners.upper - corners.lower - Vec3d{1, 1, 0}), 0, 1e-6);
    EXPECT_TRUE(world.impacts().empty()) << "nothing has moved";
    world.detect();
    EXPECT_NO_THROW(world.impacts_ahead(ahead));
    const Pose nowhere{{0, 0, INFINITY}, upright};
    EXPECT_THROW(world.impacts_ahead(std::vector<PoseAhead>{{plate, {}}}), InputError);
    EXPECT_THROW(world.impacts_ahead(std::vector<PoseAhead>{{body, nowhere}}), InputError);
    EXPECT_THROW(world.impacts_ahead(std::vector<PoseAhead>{{body, {}}, {body, {}}}), InputError);
}

TEST(ImpactsTest, SidesInOnePlaneSlide) {
    World world;
    const BodyId floor = world.add_fixed_body(
                     world.add_mesh("floor", scenes::box({-5, -5, -1}, {5, 5, 0}))),
                 step = world.add_fixed_body(
                     world.add_mesh("step", scenes::box({2, -5, 0}, {3, 5, 1}))),
                 body = world.add_rigid_body(
                     world.add_mesh("box", scenes::box({-0.5f, -5, 0}, {0.5f, 5, 1})));
    const auto along = world.impacts_ahead(std::vector<PoseAhead>{{body, {{4, 0, 0}, upright}}}, 8);
    ASSERT_FALSE(along.empty());
    for (const ImpactContact& impact : along) {
        EXPECT_EQ(impact.a, step) << "it slides on the floor";
        EXPECT_NEAR(impact.time, 1.5 / 4, 1e-6);
        EXPECT_NEAR(impact.gap, 1.5, 1e-6);
        EXPECT_NEAR(impact.normal.x, -1, 1e-9) << "the sides of the two slide";
    }
    EXPECT_EQ(along.size(), 4u) << "at the corners";
    const auto down = world.impacts_ahead(std::vector<PoseAhead>{{body, {{0, 0, -3}, upright}}});
    ASSERT_EQ(down.size(), 1u);
    EXPECT_EQ(down[0].a, floor);
    EXPECT_NEAR(down[0].gap, 0, 1e-6);
    EXPECT_NEAR(down[0].normal.z, 1, 1e-9);
    EXPECT_TRUE(world.impacts_ahead(std::vector<PoseAhead>{{body, {{0, 0, 3}, upright}}}).empty());
}

TEST(ImpactsTest, ACornerSlidesOverADiagonal) {
    for (const double depth : {0.0, 1e-6, -1e-6}) {  // within the touch tolerance of the floor
        World world;
        world.add_fixed_body(world.add_mesh("floor", scenes::box({-5, -5, -1}, {5, 5, 0})));
        const BodyId body = world.add_rigid_body(
            world.add_mesh("box", scenes::box({-0.5f, -0.5f, 0}, {0.5f, 0.5f, 1})),
            {{-2, 1, -depth}, upright});
        const auto goes = [&](double down) {
            return world.impacts_ahead(
                std::vector<PoseAhead>{{body, {{2, 1, -depth - down}, upright}}}, 8);
        };
        EXPECT_TRUE(goes(0).empty());
        EXPECT_TRUE(goes(1e-6).empty());
        const auto lands = goes(1e-3);
        EXPECT_EQ(lands.size(), 4u);
        for (const ImpactContact& impact : lands) EXPECT_NEAR(impact.normal.z, 1, 1e-9);
    }
}

TEST(ImpactsTest, BodiesThatTouchMeetWhereTheyTurnIntoEachOther) {
    World world;
    world.add_fixed_body(world.add_mesh("wall", scenes::box({-2, -0.5, -1}, {-0.5, 0, 1})));
    const BodyId body = world.add_rigid_body(
        world.add_mesh("box", scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5})));
    for (const double turn : {0.02, 0.1, 0.3}) {
        const auto meetings = world.impacts_ahead(
            std::vector<PoseAhead>{{body, {{}, {0, 0, turn, 1}}}});
        ASSERT_EQ(meetings.size(), 1u) << turn;
        EXPECT_GT(meetings[0].normal.x, 0.9);
    }
}

TEST(ImpactsTest, WhatRestsMayLeave) {
    World world;
    world.add_fixed_body(world.add_mesh("table", scenes::box({-2, -2, -1}, {2, 2, 0})));
    const MeshId shape = world.add_mesh("cube", scenes::box({-0.5f, -0.5f, 0}, {0.5f, 0.5f, 1}));
    const BodyId cube = world.add_rigid_body(shape);
    const auto impacts = [&](Vec3d from, Vec3d to) {
        world.set_motion(cube, {from, upright}, {to, upright});
        return world.impacts();
    };
    for (const double depth : {0.0, 1e-7, 5e-7, 1e-6, 2e-6}) {
        EXPECT_TRUE(impacts({1.4, 0, -depth}, {1.6, 0, -depth}).empty()) << "over the border";
        EXPECT_TRUE(impacts({0.1, 0.2, -depth}, {0.1, 0.2, 0.1}).empty()) << "up";
    }
    EXPECT_EQ(impacts({2.6, 0, -0.5}, {2.4, 0, -0.5}).size(), 1u) << "against the side";
}

TEST(ImpactsTest, AWayBeginsWhereTheLastStepHasSeenTheBody) {
    World world;
    const MeshData shape = scenes::box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f});
    const MeshId mesh = world.add_mesh("cube", shape);
    world.add_fixed_body(mesh);
    const BodyId rigid = world.add_rigid_body(mesh, {{3, 0, 0}, upright});
    const BodyId soft = world.add_deforming_body(mesh, scenes::moved(shape.positions, {0, 3, 0}));
    world.detect();
    world.set_pose(rigid, {{NAN, 0, 0}, upright});
    world.set_pose(rigid, {{-3, 0, 0}, upright});
    world.set_positions(soft, std::vector<Vec3f>(shape.positions.size(), {NAN, 0, 0}));
    world.set_positions(soft, scenes::moved(shape.positions, {0, -3, 0}));
    EXPECT_EQ(world.impacts().size(), 3u) << "with the fixed one, and with each other";

    world.remove_body(soft);
    world.set_pose(rigid, {{NAN, 0, 0}, upright});
    world.detect();
    world.set_pose(rigid, {{3, 0, 0}, upright});
    EXPECT_TRUE(world.impacts().empty()) << "the last step has not seen it";
    world.set_pose(rigid, {{-3, 0, 0}, upright});
    EXPECT_EQ(world.impacts().size(), 1u) << "it begins where it was put first";
}

TEST(ImpactsTest, AheadIsWhatAMotionWouldMeet) {
    test::Random random(23);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int i = 0; i < 40; ++i) {
        World world;
        std::vector<PoseAhead> ahead;
        std::vector<Pose> starts;
        for (int k = 0; k < 4; ++k) {
            const Pose start{random.in_box(3), random.rotation()},
                end{random.in_box(3), random.rotation()};
            const MeshId mesh = world.add_mesh("shape", test::random_closed_mesh(random));
            const BodyId body = world.add_rigid_body(mesh, start);
            if (k == 0) continue;  // this one stays
            starts.push_back(start);
            ahead.push_back({body, end});
        }
        const auto before = world.impacts_ahead(ahead, 3);
        for (std::size_t k = 0; k < ahead.size(); ++k)
            world.set_motion(ahead[k].body, starts[k], ahead[k].pose);
        const auto after = world.impacts(3);
        ASSERT_EQ(before.size(), after.size());
        for (std::size_t k = 0; k < before.size(); ++k) {
            EXPECT_EQ(before[k].a, after[k].a);
            EXPECT_EQ(before[k].time, after[k].time);
            EXPECT_EQ(before[k].gap, after[k].gap);
            EXPECT_EQ(before[k].vertex, after[k].vertex);
        }
    }
}

TEST(ImpactsTest, NeitherEarlyNorLate) {
    test::Random random(21);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int meetings = 0, edges = 0, misses = 0;
    for (int i = 0; i < 120; ++i) {
        const MeshData mesh[2] = {
            i % 3 == 0 ? scenes::torus(0.8, 0.2, 10, 6) : test::random_closed_mesh(random),
            test::random_closed_mesh(random)};
        World world;
        std::vector<Vec3f> start[2], end[2];
        BodyId body[2];
        for (int k = 0; k < 2; ++k) {
            const double side = k == 0 ? -2.2 : 2.2;
            const Quaternion turn = random.rotation();
            start[k] = test::placed(mesh[k], {random.in_box(0.8) + Vec3d{side, 0, 0}, turn});
            end[k] = test::placed(mesh[k], {random.in_box(1.2) - Vec3d{0.6 * side, 0, 0},
                                            i % 2 == 0 ? turn : random.rotation()});
            body[k] = world.add_deforming_body(world.add_mesh("shape", mesh[k]));
            world.set_motion(body[k], start[k], end[k]);
        }
        const auto overlaps_at = [&](double t) {
            for (int k = 0; k < 2; ++k) world.set_positions(body[k], between(start[k], end[k], t));
            return world.overlap(body[0], body[1]).has_value();
        };
        const auto impacts = world.impacts();
        if (overlaps_at(0)) {
            EXPECT_TRUE(impacts.empty());
            continue;
        }
        constexpr int samples = 200;
        double first = 2;
        for (int n = 1; n <= samples && first > 1; ++n)
            if (overlaps_at(n / double{samples})) first = n / double{samples};
        if (impacts.empty()) {
            EXPECT_GT(first, 1) << "missed in motion " << i;
            ++misses;
            continue;
        }
        const ImpactContact& impact = impacts[0];
        ++meetings;
        edges += impact.edges;
        EXPECT_LE(impact.time, first) << "late in motion " << i;
        EXPECT_GE(impact.gap, 0);
        // What meets is there at that time.
        const int source = impact.source == Side::a ? 0 : 1;
        const auto at = [&](int k, std::uint32_t v) {
            return to_double(start[k][v]) +
                   impact.time * (to_double(end[k][v]) - to_double(start[k][v]));
        };
        const Triangle& t = mesh[1 - source].triangles[impact.triangle];
        const Vec3d a = at(1 - source, t.vertex[0]),
                    n = cross(at(1 - source, t.vertex[1]) - a, at(1 - source, t.vertex[2]) - a);
        if (!impact.edges) {
            EXPECT_NEAR(length(at(source, impact.vertex) - impact.point), 0, 1e-9);
            EXPECT_NEAR(dot(impact.point - a, normalized(n)), 0, 1e-5);
            EXPECT_NEAR(std::fabs(dot(impact.normal, normalized(n))), 1, 1e-9);
        } else {
            const Vec3d along = at(0, impact.edge_end) - at(0, impact.vertex);
            EXPECT_NEAR(dot(impact.normal, normalized(along)), 0, 1e-9);
        }
    }
    EXPECT_GT(meetings, 40);
    EXPECT_GT(edges, 10);
    EXPECT_GT(misses, 5);
}

/// Boxes on a grid, many of which touch when they begin.
TEST(ImpactsTest, NeitherEarlyNorLateWhereBodiesTouch) {
    test::Random random(33);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const auto on_grid = [&](double step, int most) {
        const auto number = [&] { return step * random.integer(-most, most); };
        return Vec3d{number(), number(), number()};
    };
    const MeshData boxes[] = {scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}),
                              scenes::box({-1, -0.5, -0.25}, {1, 0.5, 0.25})};
    int meetings = 0, misses = 0, touching = 0;
    for (int i = 0; i < 1500; ++i) {
        const MeshData &first = boxes[random.integer(0, 1)], &second = boxes[random.integer(0, 1)];
        World world;
        world.add_fixed_body(world.add_mesh("first", first));
        const BodyId b = world.add_rigid_body(world.add_mesh("second", second));
        const Pose start{on_grid(0.5, 3), upright};
        const Vec3d turn = on_grid(0.1, 1);
        const Pose end{start.position + on_grid(0.5, 3), {turn.x, turn.y, turn.z, 1}};
        World between_poses;
        const BodyId c = between_poses.add_fixed_body(between_poses.add_mesh("first", first)),
                     d = between_poses.add_deforming_body(between_poses.add_mesh("second", second));
        const std::vector<Vec3f> from = test::placed(second, start), to = test::placed(second, end);
        const auto volume_at = [&](double t) {
            between_poses.set_positions(d, between(from, to, t));
            const auto overlap = between_poses.overlap(c, d);
            return overlap ? overlap->volume : 0.0;
        };
        world.set_pose(b, start);
        if (volume_at(0) > 0) continue;
        world.detect();
        touching += !world.contacts().empty();
        const auto impacts = world.impacts_ahead(std::vector<PoseAhead>{{b, end}});
        constexpr int samples = 40;
        double met = 2;
        for (int n = 1; n <= samples && met > 1; ++n)
            if (volume_at(n / double{samples}) > 1e-4) met = n / double{samples};
        if (met <= 1) {
            ++meetings;
            ASSERT_FALSE(impacts.empty()) << "missed in motion " << i;
            EXPECT_LE(impacts[0].time, met) << "late in motion " << i;
        } else {
            misses += impacts.empty();
        }
    }
    EXPECT_GT(meetings, 200);
    EXPECT_GT(misses, 200);
    EXPECT_GT(touching, 100);
}

TEST(ImpactsTest, WhatIsInsideAsAWholeOverlapsHoweverSmallItIs) {
    for (const float size : {1e-1f, 1e-4f, 1e-6f, 1e-8f}) {
        World world;
        const BodyId large = world.add_rigid_body(
            world.add_mesh("large", scenes::box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f})));
        const BodyId small = world.add_rigid_body(
            world.add_mesh("small", scenes::box({0, 0, 0}, {size, size, size})));
        world.set_pose(small, {{2, 0.1, 0.2}, upright});
        EXPECT_TRUE(world.impacts().empty()) << size;
        world.detect();
        world.set_pose(small, {{0, 0.1, 0.2}, upright});
        ASSERT_EQ(world.impacts().size(), 1u) << size;
        EXPECT_EQ(world.impacts()[0].a, large);
    }
}

TEST(ImpactsTest, AnUnusedVertexIsNoPlaceOutside) {
    World world;
    world.add_fixed_body(world.add_mesh("large", scenes::box({-500, -500, -500}, {500, 500, 500})));
    MeshData ball = scenes::sphere(1e-3, 1);
    ball.positions.push_back({0, 0, 0});
    const BodyId small = world.add_rigid_body(world.add_mesh("small", ball));
    world.set_motion(small, {{499, 3, 7}, upright}, {{505, 3, 7}, upright});
    EXPECT_TRUE(world.impacts().empty());
}

TEST(ImpactsTest, AFarUnusedVertexDoesNotChangeWhatCounts) {
    const auto impact = [](float far) {
        World world;
        MeshData floor = scenes::box({-1, -1, -1}, {1, 1, 0});
        if (far > 0) floor.positions.push_back({0, 0, far});
        world.add_fixed_body(world.add_mesh("floor", floor));
        const BodyId box = world.add_rigid_body(
            world.add_mesh("box", scenes::box({-0.25f, -0.25f, 0}, {0.25f, 0.25f, 0.5f})));
        world.set_motion(box, {{0, 0, 0}, upright}, {{0, 0, -0.2}, upright});
        return world.impacts();
    };
    const std::vector<ImpactContact> plain = impact(0);
    ASSERT_EQ(plain.size(), 1u);
    for (const float far : {1e3f, 1e6f}) {
        const std::vector<ImpactContact> with = impact(far);
        ASSERT_EQ(with.size(), 1u) << far;
        EXPECT_EQ(with[0].time, plain[0].time) << far;
    }
}

/// A needle whose tip touches beside the bottom of a groove, and falls.
TEST(ImpactsTest, ATipInAGroove) {
    MeshData groove;
    const std::array<Vec3d, 5> outline = {
        {{-4, 0, -6}, {4, 0, -6}, {4, 0, 4}, {0, 0, 0}, {-4, 0, 4}}};
    for (const double y : {-10.0, 10.0})
        for (const Vec3d p : outline) groove.positions.push_back(to_float({p.x, y, p.z}));
    for (std::uint32_t k = 0; k < 5; ++k) {
        const std::uint32_t next = (k + 1) % 5;
        groove.triangles.push_back({{k, next + 5, next}});
        groove.triangles.push_back({{k, k + 5, next + 5}});
    }
    for (const Triangle& t : {Triangle{{0, 1, 3}}, Triangle{{1, 2, 3}}, Triangle{{3, 4, 0}}}) {
        const auto [a, b, c] = std::to_array(t.vertex);
        groove.triangles.push_back({{a, b, c}});
        groove.triangles.push_back({{a + 5, c + 5, b + 5}});
    }
    MeshData needle{{{0, 0, 0}}, {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 1}}, {{1, 3, 2}}}};
    for (int k = 0; k < 3; ++k) {
        const double angle = 2 * std::numbers::pi * k / 3, lean = 1.1;
        needle.positions.push_back(
            to_float(3 * Vec3d{std::cos(lean), 0, std::sin(lean)} +
                     0.3 * std::cos(angle) * Vec3d{-std::sin(lean), 0, std::cos(lean)} +
                     0.3 * std::sin(angle) * Vec3d{0, 1, 0}));
    }
    World world;
    const MeshId groove_mesh = world.add_mesh("groove", groove),
                 needle_mesh = world.add_mesh("needle", needle);
    ASSERT_GT(world.mesh(groove_mesh).traits().volume, 0);
    ASSERT_GT(world.mesh(needle_mesh).traits().volume, 0);
    world.add_fixed_body(groove_mesh);
    const BodyId falls = world.add_rigid_body(needle_mesh);
    for (int i = 0; i <= 40; ++i)
        for (const double drop : {0.05, 0.5, 2.0})
            for (const double lift : {0.0, 1e-7, 1e-6, -1e-6}) {
                const double beside = 0.5e-6 * i;
                const Vec3d tip{beside, 0.3, beside + lift};
                world.set_motion(falls, {tip, upright}, {tip - Vec3d{0, 0, drop}, upright});
                EXPECT_EQ(world.impacts().size(), 1u) << beside << " " << drop << " " << lift;
            }
}

/// All lengths are relative: in another unit the same boxes meet at the same time, and the way
/// between them is the same one.
TEST(ImpactsTest, TheUnitDoesNotMatter) {
    test::Random random(31);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int edges = 0;
    for (int i = 0; i < 400; ++i) {
        std::array<Pose, 4> place;  // of two boxes as they begin, and as they end
        for (Pose& p : place) p = {random.in_box(1.5), random.rotation()};
        const auto meet = [&](double unit) {
            const auto half = static_cast<float>(unit / 2);
            World world(reference_backend());
            const MeshId box = world.add_mesh(
                "box", scenes::box({-half, -half, -half}, {half, half, half}));
            const auto at = [&](int k) {
                return Pose{unit * place[k].position, place[k].rotation};
            };
            for (const int k : {0, 1})
                world.set_motion(world.add_rigid_body(box), at(k), at(k + 2));
            return world.impacts();
        };
        const auto expected = meet(1);
        edges += !expected.empty() && expected[0].edges;
        for (const double unit : {0x1p-11, 0x1p-20, 0x1p20}) {
            const auto impacts = meet(unit);
            ASSERT_EQ(impacts.size(), expected.size()) << "motion " << i << ", unit " << unit;
            for (std::size_t k = 0; k < impacts.size(); ++k) {
                EXPECT_EQ(impacts[k].time, expected[k].time);
                EXPECT_EQ(impacts[k].gap, unit * expected[k].gap) << "unit " << unit;
                EXPECT_NEAR(dot(impacts[k].normal, expected[k].normal), 1, 1e-12);
            }
        }
    }
    EXPECT_GT(edges, 50);
}

/// The touch tolerance is that of contacts, not one of the large body.
TEST(ImpactsTest, ASmallBodyOnALargeFloor) {
    for (const float half : {1.0f, 100.0f, 500.0f}) {
        World world;
        world.add_fixed_body(
            world.add_mesh("floor", scenes::box({-half, -half, -1}, {half, half, 0})));
        const BodyId box = world.add_rigid_body(
            world.add_mesh("box", scenes::box({-0.005f, -0.005f, 0}, {0.005f, 0.005f, 0.01f})));
        world.set_motion(box, {{0, 0, 0}, upright}, {{0, 0, -1e-5}, upright});
        EXPECT_EQ(world.impacts().size(), 1u) << half;
        world.set_motion(box, {{0, 0, -1e-4}, upright}, {{0, 0, -2e-4}, upright});
        EXPECT_TRUE(world.impacts().empty()) << half << ": they overlap as the step begins";
    }
}

/// A box slides over a floor of squares, into which rounding has sunk it: no border of a square is
/// in its way.
TEST(ImpactsTest, WhatSlidesOverSquaresMeetsNoneOfTheirBorders) {
    MeshData floor = scenes::grid(8, 4, 8, 4);
    for (Vec3f& p : floor.positions) p.z = 0;
    const auto top = static_cast<std::uint32_t>(floor.positions.size());
    for (std::uint32_t v = 0; v < top; ++v) {
        Vec3f below = floor.positions[v];
        below.z = -1;
        floor.positions.push_back(below);
    }
    const std::vector<Triangle> upper = floor.triangles;
    std::set<std::pair<std::uint32_t, std::uint32_t>> sides;
    for (const Triangle& t : upper) {
        floor.triangles.push_back({{top + t.vertex[0], top + t.vertex[2], top + t.vertex[1]}});
        for (int k = 0; k < 3; ++k) sides.emplace(t.vertex[k], t.vertex[(k + 1) % 3]);
    }
    for (const auto& [a, b] : sides)
        if (!sides.contains({b, a})) {
            floor.triangles.push_back({{b, a, top + a}});
            floor.triangles.push_back({{b, top + a, top + b}});
        }
    World world;
    const MeshId squares = world.add_mesh("floor", floor);
    ASSERT_TRUE(world.mesh(squares).traits().closed());
    ASSERT_GT(world.mesh(squares).traits().volume, 0);
    world.add_fixed_body(squares);
    const BodyId box = world.add_rigid_body(
        world.add_mesh("box", scenes::box({-0.5f, -0.4f, 0}, {0.5f, 0.4f, 0.6f})));
    test::Random random(1);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int k = 0; k < 300; ++k) {
        const auto some = [&](double size) { return size * random.uniform(-1, 1); };
        const double x = (k % 2 == 0 ? 0.5 : 0.4) + some(1e-5), y = 0.65 + some(1e-5),
                     z = some(3e-6) - 1e-6;
        const Quaternion turn{some(2e-6), some(2e-6), 0, 1};
        world.set_motion(box, {{x, y, z}, turn},
                         {{x + 1.0 / 6, y, z - random.uniform(0, 3e-3)}, turn});
        for (const ImpactContact& impact : world.impacts(8))
            EXPECT_GT(impact.normal.z, 0.9) << k << ": " << impact.normal.x;
    }
}

TEST(ImpactsTest, OnlyPairsThatMoveMeetAndWereApart) {
    World world;
    const MeshId ball = world.add_mesh("ball", scenes::sphere(0.5, 1)),
                 flat = world.add_mesh("flat", scenes::grid(2, 2, 4, 4));
    const BodyId a = world.add_rigid_body(ball, {{0, 0, 0}, upright}),
                 b = world.add_rigid_body(ball, {{5, 0, 0}, upright}),
                 inside = world.add_rigid_body(ball, {{0.1, 0, 0}, upright});
    world.add_rigid_body(flat, {{3, 0, 0}, upright});
    EXPECT_TRUE(world.impacts().empty()) << "nothing moves";
    world.set_pose(b, {{-5, 0, 0}, upright});
    auto impacts = world.impacts();
    ASSERT_EQ(impacts.size(), 2u) << "the two overlapping balls, and no surface without an inside";
    EXPECT_EQ(impacts[0].a, a);
    EXPECT_EQ(impacts[0].b, b);
    EXPECT_EQ(impacts[1].a, b);
    EXPECT_EQ(impacts[1].b, inside);
    EXPECT_GT(impacts[0].normal.x, 0.9);
    EXPECT_LT(impacts[1].normal.x, -0.9);
    world.exclude(a, b);
    EXPECT_EQ(world.impacts().size(), 1u);
    world.set_filter(b, {.meets = 2});
    EXPECT_TRUE(world.impacts().empty());
}

}  // namespace
}  // namespace pierce
