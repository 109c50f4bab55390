// Coarse bodies that stand on a table, across its rim or flush with it, hardly deeper than they
// touch: no contact and no patch is much deeper than the body.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "pierce/constants.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/prism.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

constexpr double touch = 2e-5;  ///< more than any pair's touch tolerance

class OverRimTest : public testing::TestWithParam<test::NamedBackend> {};

MeshData table() { return scenes::box({-1, -0.25, -1}, {1, 0, 1}); }

/// Bodies that stand on y = 0: a frustum and prisms, wider below, and a box.
std::vector<MeshData> standing_bodies() {
    const std::vector<Triangle> quad{{{0, 1, 2}}, {{0, 2, 3}}}, triangle{{{0, 1, 2}}};
    std::vector<MeshData> all{
        test::prism({{-0.3f, 0, 0}, {0.3f, 0, 0}, {0.2f, 0.2f, 0}, {-0.2f, 0.2f, 0}}, quad),
        test::prism({{-0.25f, 0, 0}, {0.25f, 0, 0}, {0, 0.5f, 0}}, triangle),
        test::prism({{-0.5f, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}}, triangle),
        scenes::box({-0.3, 0, -0.3}, {0.3, 0.2, 0.3})};
    for (std::size_t k = 0; k < 3; ++k)
        for (Vec3f& p : all[k].positions) p.z *= 0.3f;
    for (Vec3f& p : all[0].positions)
        if (p.y > 0) p.z *= 0.6f;
    return all;
}

double deepest_of(const World& world) {
    double deepest = 0;
    for (const Contact& c : world.contacts()) deepest = std::max(deepest, c.penetration_depth());
    return deepest;
}

// The base is the way out, although it leads into the faces beside every ridge.
TEST_P(OverRimTest, WhatStandsAcrossARimIsNoDeeperThanItIs) {
    test::Random random(3);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (const Coverage coverage : {Coverage::overlaps, Coverage::complete})
        for (const MeshData& mesh : standing_bodies()) {
            World world(GetParam().make(), {.coverage = coverage});
            world.add_fixed_body(world.add_mesh("table", table()));
            const BodyId body = world.add_rigid_body(world.add_mesh("body", mesh));
            int met = 0;
            for (int i = 0; i < 120; ++i) {
                const double down = std::pow(10, random.uniform(-5, -3)),
                             turn = random.uniform(0, 6.28);
                const Pose pose{
                    {random.uniform(0.6, 1.2), -down, i % 2 == 0 ? 0.0 : random.uniform(0.6, 1.2)},
                    {0, std::sin(turn / 2), 0, std::cos(turn / 2)}};
                world.set_pose(body, pose);
                world.detect();
                met += !world.contacts().empty();
                EXPECT_LE(deepest_of(world), 2 * down + touch) << i;
            }
            EXPECT_GT(met, 80);
        }
}

// A ray along the end's face, against the normal of the plate's side, runs through all of the
// floor.
TEST_P(OverRimTest, APlateThatIsFlushWithAFloorsEndOnlyTouches) {
    test::Random random(4);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (const double height : {0.2, 0.02}) {
        World world(GetParam().make());
        world.add_fixed_body(world.add_mesh("table", table()));
        const BodyId body = world.add_rigid_body(
            world.add_mesh("plate", scenes::box({-0.5, 0, -0.5}, {0.5, height, 0.5})));
        for (int i = 0; i < 300; ++i) {
            const double down = std::pow(10, random.uniform(-8, -4.7)),
                         away = i % 2 == 0 ? 0.0 : random.uniform(-1e-6, 1e-6);
            world.set_pose(body,
                           {{0.5 + away, -down, random.uniform(-0.4, 0.4)},
                            {random.uniform(-down, down), 0, random.uniform(-down, down), 1}});
            world.detect();
            EXPECT_FALSE(world.contacts().empty());
            EXPECT_LE(deepest_of(world), 4 * down + touch) << i;
        }
    }
}

// At a right angle, the faces beside the ridge hide what lies behind them.
TEST_P(OverRimTest, ABoxThatStandsTurnedOverACornerIsPushedUp) {
    const double turn = std::atan2(0.1, 0.5), half = 0.6;
    const Vec3d middle = 0.5 * (Vec3d{1, 0, 0.5} + Vec3d{0.9, 0, 1}) +
                         half * normalized(Vec3d{0.5, 0, 0.1});
    for (const Coverage coverage : {Coverage::overlaps, Coverage::complete})
        for (const double down : {0.01, 0.018, 0.02, 0.03, 0.08}) {
            World world(GetParam().make(), {.coverage = coverage});
            world.add_fixed_body(world.add_mesh("table", scenes::box({-1, -2, -1}, {1, 0, 1})));
            world.add_rigid_body(
                world.add_mesh("box", scenes::box({-half, 0, -half}, {half, 2 * half, half})),
                {{middle.x, -down, middle.z}, {0, -std::sin(turn / 2), 0, std::cos(turn / 2)}});
            world.detect();
            EXPECT_FALSE(world.contacts().empty());
            for (const Contact& c : world.contacts()) {
                EXPECT_NEAR(c.penetration_depth(), down, 1e-6);
                EXPECT_NEAR(c.normal.y, 1, 1e-6);
            }
        }
}

// Ridges beside a pair that hardly touches have passed each other by much more than it is deep.
TEST_P(OverRimTest, RidgesHavePassedEachOtherNoFurtherThanTheirPairIsDeep) {
    for (const double deep : {-1e-7, 1e-7, 5e-7, 1.5e-6, 1e-5, 1e-4}) {
        World world(GetParam().make(), {.margin = 0.08});
        world.add_fixed_body(world.add_mesh("box", scenes::box({-1, -0.5, -0.25}, {1, 0.5, 0.25})));
        world.add_rigid_body(world.add_mesh("plate", scenes::box({-0.0625, -0.125, -0.015625},
                                                                 {0.0625, 0.125, 0.015625})),
                             {{0.9375, 0.625 - deep, -0.25}, {}});
        world.detect();
        EXPECT_FALSE(world.contacts().empty());
        for (const Contact& c : world.contacts())
            EXPECT_GE(c.distance, -(constants::passed_depths * std::max(deep, 0.0) + touch))
                << deep;
    }
}

// One leg of a U ends flush with the table.
TEST_P(OverRimTest, PatchesBesideAFlushFaceAreNoDeeperThanTheirPair) {
    World world(GetParam().make());
    const BodyId below = world.add_fixed_body(world.add_mesh("table", table()));
    MeshData u = test::prism(
        {{-0.25f, 0, 0},
         {0.25f, 0, 0},
         {0.25f, 0.5f, 0},
         {0.125f, 0.5f, 0},
         {0.125f, 0.125f, 0},
         {-0.125f, 0.125f, 0},
         {-0.125f, 0.5f, 0},
         {-0.25f, 0.5f, 0}},
        {{{0, 1, 4}}, {{0, 4, 5}}, {{1, 2, 4}}, {{2, 3, 4}}, {{0, 5, 7}}, {{5, 6, 7}}});
    for (Vec3f& p : u.positions) p.z *= 0.25f;
    const BodyId body = world.add_rigid_body(world.add_mesh("u", u));
    int patches = 0;
    for (const double down : {1e-7, 1e-6, 1e-5, 1e-4, 1e-3})
        for (const auto& [x, z] : {std::pair{0.75, 0.875}, {0.75, 1.0}, {0.875, 1.0}, {0.0, 1.0}})
            for (const double lean : {0.0, 0.5, -0.5}) {
                world.set_pose(body, {{x, -down, z}, {lean * down / 2, 0, 0, 1}});
                const auto overlap = world.overlap(below, body);
                if (!overlap) continue;
                for (const ContactPatch& patch : overlap->patches) {
                    ++patches;
                    EXPECT_LE(patch.depth, 3 * down) << down << " " << x << " " << z;
                }
            }
    EXPECT_GT(patches, 30);
}

INSTANTIATE_TEST_SUITE_P(Backends, OverRimTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
