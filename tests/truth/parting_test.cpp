// How far pairs have to move until they are apart, against exact predicates and exact minimum
// translations.
#include "pierce/parting.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "pierce/world.hpp"
#include "scenes/named/hard_cases.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"
#include "support/t_junction.hpp"
#include "truth/cubes.hpp"
#include "truth/exact_mesh.hpp"
#include "truth/minimum_translation.hpp"

namespace pierce::truth {
namespace {

/// Two meshes in a world, and what is true of them.
struct Placed {
    MeshData a, b;
    Pose pose_a, pose_b;

    static std::vector<Vec3d> in_world(const MeshData& mesh, const Pose& pose) {
        std::vector<Vec3d> points;
        for (Vec3f p : mesh.positions) points.push_back(frame_of(pose).to_parent(to_double(p)));
        return points;
    }
    bool overlap_after(Vec3d way) const {
        const ExactMesh first(in_world(a, pose_a), a.triangles),
            second(in_world(b, pose_b), b.triangles);
        return first.overlaps(second, Frame{{}, way});
    }
    double minimum() const {
        const std::vector<Vec3d> first = in_world(a, pose_a), second = in_world(b, pose_b);
        return minimum_translation({first, a.triangles}, {second, b.triangles}).length;
    }
    std::optional<Parting> parting(bool deforms = false) const {
        World world;
        const auto add = [&](const MeshData& mesh, const Pose& pose) {
            const MeshId id = world.add_mesh("mesh", mesh);
            return deforms ? world.add_deforming_body(id, test::placed(mesh, pose))
                           : world.add_rigid_body(id, pose);
        };
        const BodyId first = add(a, pose_a), second = add(b, pose_b);
        return world.parting(first, second);
    }
};

/// More than touch tolerances of these bodies, none of which is longer than eight.
constexpr double little = 8 * 4 * constants::touch_tolerance;

TEST(PartingTest, HardCasesPartAsSoonAsTheyCan) {
    int overlapping = 0;
    for (const scenes::HardCase& hard : scenes::hard_cases())
        for (const scenes::HardBodies& bodies : hard.bodies) {
            SCOPED_TRACE(hard.name + " " + bodies.situation);
            const Placed pair{bodies.a, bodies.b, {}, {}};
            const std::optional<Parting> parting = pair.parting();
            EXPECT_EQ(parting.has_value(), bodies.parting > 0);
            if (!parting) continue;
            ++overlapping;
            EXPECT_NEAR(parting->depth, bodies.parting, little);
            EXPECT_NEAR(length(parting->direction), 1, 1e-12);
        }
    EXPECT_EQ(overlapping, 13);
}

TEST(PartingTest, ConvexBodiesMoveAsFarAsTheyMust) {
    test::Random random(71);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    int overlapping = 0;
    for (int i = 0; i < 150; ++i) {
        const auto shape = [&]() -> MeshData {
            switch (random.integer(0, 2)) {
                case 0:
                    return scenes::sphere(random.uniform(0.3, 1), random.integer(0, 2));
                case 1:
                    return scenes::box(Vec3d{-1, -1, -1} + random.in_box(0.8),
                                       Vec3d{1, 1, 1} + random.in_box(0.8));
                default: {
                    MeshData mesh{{}, {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}};
                    for (int k = 0; k < 4; ++k)
                        mesh.positions.push_back(to_float(random.in_box(1)));
                    const auto at = [&](int k) { return to_double(mesh.positions[k]); };
                    if (dot(cross(at(1) - at(0), at(2) - at(0)), at(3) - at(0)) < 0)
                        std::swap(mesh.positions[0], mesh.positions[1]);
                    return mesh;
                }
            }
        };
        const Placed pair{shape(),
                          shape(),
                          {{}, random.rotation()},
                          {random.uniform(0, 2) * random.unit_vector(), random.rotation()}};
        const double least = pair.minimum();
        const std::optional<Parting> parting = pair.parting();
        if (least <= 0) {
            EXPECT_FALSE(parting) << i;
            continue;
        }
        if (least < little) continue;
        ASSERT_TRUE(parting) << i;
        EXPECT_GE(parting->depth, least - little) << i;
        EXPECT_FALSE(pair.overlap_after((parting->depth + little) * parting->direction)) << i;
        EXPECT_NEAR(parting->depth, least, 1e-9) << i;
        ++overlapping;
    }
    EXPECT_GT(overlapping, 60);
}

/// The mesh in another place, to the rounding of its positions.
MeshData moved(MeshData mesh, const Pose& pose) {
    mesh.positions = test::placed(mesh, pose);
    return mesh;
}

TEST(PartingTest, TJunctionsMakeNoDifferenceToConvexBodies) {
    test::Random random(73);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    int overlapping = 0;
    for (int i = 0; i < 200; ++i) {
        const auto shape = [&] {
            const MeshData mesh = random.integer(0, 1) == 0
                                      ? scenes::sphere(random.uniform(0.3, 1), 1)
                                      : scenes::box({-1, -1, -1}, {1, 1, 1});
            return moved(mesh, {random.in_box(0.8), random.rotation()});
        };
        Placed pair{shape(), shape(), {{}, random.rotation()}, {{}, random.rotation()}};
        const std::optional<Parting> smooth = pair.parting();
        for (MeshData* mesh : {&pair.a, &pair.b})
            for (int k = random.integer(0, 12); k > 0; --k)
                test::add_t_junction(*mesh,
                                     static_cast<std::size_t>(random.integer(
                                         0, static_cast<int>(mesh->triangles.size()) - 1)),
                                     random.integer(0, 2), random.uniform(0.01, 0.99));
        const std::optional<Parting> cut = pair.parting();
        if (!smooth || smooth->depth < little) continue;
        ASSERT_TRUE(cut) << i;
        EXPECT_NEAR(cut->depth, smooth->depth, little) << i;
        ++overlapping;
    }
    EXPECT_GT(overlapping, 100);
}

// It is closed, convex at each edge and obeys Euler, but winds around its middle seven times.
TEST(PartingTest, TheGreatIcosahedronIsNotConvex) {
    const double golden = (1 + std::sqrt(5.0)) / 2;
    MeshData star;
    for (const double s : {-1.0, 1.0})
        for (const double t : {-golden, golden})
            for (const Vec3d p : {Vec3d{0, s, t}, Vec3d{s, t, 0}, Vec3d{t, 0, s}})
                star.positions.push_back(to_float(p));
    const auto at = [&](std::uint32_t v) { return to_double(star.positions[v]); };
    const auto are_joined = [&](std::uint32_t v, std::uint32_t w) {
        return std::fabs(length(at(v) - at(w)) - 2 * golden) < 1e-3;
    };
    for (std::uint32_t a = 0; a < 12; ++a)
        for (std::uint32_t b = a + 1; b < 12; ++b)
            for (std::uint32_t c = b + 1; c < 12; ++c) {
                if (!are_joined(a, b) || !are_joined(b, c) || !are_joined(a, c)) continue;
                const bool faces_out = dot(cross(at(b) - at(a), at(c) - at(a)), at(a)) > 0;
                star.triangles.push_back(faces_out ? Triangle{{a, b, c}} : Triangle{{a, c, b}});
            }
    ASSERT_EQ(star.triangles.size(), 20u);
    EXPECT_TRUE(Mesh("star", star).traits().closed());
    EXPECT_FALSE(is_convex(Mesh("star", star)));
    EXPECT_TRUE(is_convex(Mesh("ball", scenes::sphere(1, 2))));
}

TEST(PartingTest, SeveralConvexPartsAreNoConvexBody) {
    World world;
    const MeshId posts = world.add_mesh(
        "posts",
        scenes::joined(scenes::box({0, 0, 0}, {1, 1, 1}), scenes::box({100, 0, 0}, {101, 1, 1})));
    const BodyId a = world.add_fixed_body(posts),
                 b = world.add_rigid_body(world.add_mesh("ball", scenes::sphere(0.5, 2)),
                                          {{1.4, 0.5, 0.5}, {}});
    const std::optional<Parting> parting = world.parting(a, b);
    ASSERT_TRUE(parting);
    EXPECT_NEAR(parting->depth, 0.1, 0.01);
}

/// A prism over a polygon, from z = -height / 2 to height / 2.
MeshData prism(const std::vector<Vec3f>& corners, std::vector<Triangle> lid, float height) {
    MeshData mesh;
    const auto n = static_cast<std::uint32_t>(corners.size());
    for (const float z : {-height / 2, height / 2})
        for (const Vec3f p : corners) mesh.positions.push_back({p.x, p.y, z});
    for (const Triangle& t : lid) {
        mesh.triangles.push_back({{t.vertex[0] + n, t.vertex[1] + n, t.vertex[2] + n}});
        mesh.triangles.push_back({{t.vertex[0], t.vertex[2], t.vertex[1]}});
    }
    for (std::uint32_t k = 0; k < n; ++k) {
        const std::uint32_t next = (k + 1) % n;
        mesh.triangles.push_back({{k, next, next + n}});
        mesh.triangles.push_back({{k, next + n, k + n}});
    }
    return mesh;
}

/// A bar with a groove along z, at whose bottom lies a strip.
MeshData grooved_bar(float strip) {
    return prism({{-strip / 2, 0.5f, 0},
                  {-0.5f, 1, 0},
                  {-2, 1, 0},
                  {-2, -1, 0},
                  {2, -1, 0},
                  {2, 1, 0},
                  {0.5f, 1, 0},
                  {strip / 2, 0.5f, 0}},
                 {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 4}}, {{0, 4, 7}}, {{7, 4, 5}}, {{7, 5, 6}}}, 2);
}

TEST(PartingTest, ABarWithAGrooveIsNotConvexHoweverNarrowItsBottomIs) {
    for (const float strip : {1e-6f, 4e-6f, 1e-5f, 1e-4f, 1e-2f}) {
        const Mesh bar("bar", grooved_bar(strip));
        EXPECT_NEAR(bar.traits().volume, 2 * (8 - 0.25), 0.02) << strip;
        EXPECT_FALSE(is_convex(bar)) << strip;
    }
}

// On the way apart, faces come to lie on each other where the bodies overlap most.
TEST(PartingTest, BodiesWithCommonMeasuresAreApartAfterwards) {
    const MeshData ell = prism({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}},
                               {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 4}}, {{0, 4, 5}}}, 1);
    const MeshData cube = scenes::box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}),
                   bar = scenes::box({-0.5f, -0.15f, -0.15f}, {0.5f, 0.15f, 0.15f});
    test::Random random(8);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    int overlapping = 0;
    for (int i = 0; i < 60; ++i) {
        const Vec3d where{0.7 + 0.6 * random.uniform(-1, 1), 0.9 + 0.7 * random.uniform(-1, 1),
                          0.2 * random.uniform(-1, 1)};
        const Placed pair{ell, i % 2 == 0 ? cube : bar, {}, {where, {}}};
        const std::optional<Parting> parting = pair.parting();
        if (!parting) continue;
        ++overlapping;
        EXPECT_FALSE(pair.overlap_after((parting->depth + little) * parting->direction)) << i;
    }
    EXPECT_GT(overlapping, 40);
}

TEST(PartingTest, FarAwayConvexBodiesMoveAsFarAsNearOnes) {
    test::Random random(9);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    const MeshData cube = scenes::box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f});
    for (int i = 0; i < 20; ++i) {
        const Pose one{{}, random.rotation()}, other{random.in_box(0.6), random.rotation()};
        const std::optional<Parting> near = Placed{cube, cube, one, other}.parting();
        if (!near) continue;
        const Vec3d far{300, -200, 100};
        const auto moved_by = [&](Pose pose) {
            pose.position += far;
            return pose;
        };
        const std::optional<Parting> away = Placed{cube, cube, moved_by(one), moved_by(other)}
                                                .parting(true);
        ASSERT_TRUE(away) << i;
        EXPECT_NEAR(away->depth, near->depth, 2e-4) << i;
    }
}

TEST(PartingTest, AnyBodiesAreApartAfterwards) {
    test::Random random(72);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    int overlapping = 0;
    for (int i = 0; i < 80; ++i) {
        const Placed pair{test::random_closed_mesh(random),
                          test::random_closed_mesh(random),
                          {{}, random.rotation()},
                          {random.uniform(0, 1.6) * random.unit_vector(), random.rotation()}};
        const bool deforms = i % 2 == 1;  // positions are rounded then
        const std::optional<Parting> parting = pair.parting(deforms);
        if (!pair.overlap_after({})) {
            EXPECT_TRUE(!parting || (deforms && parting->depth < little)) << i;
            continue;
        }
        overlapping += parting.has_value();
        const Vec3d way = parting ? parting->direction : Vec3d{0, 0, 1};
        EXPECT_FALSE(pair.overlap_after(((parting ? parting->depth : 0) + little) * way)) << i;
    }
    EXPECT_GT(overlapping, 30);
}

// Steps do not look at bodies beyond the largest coordinate: that is not the same as apart.
TEST(PartingTest, TheMovePartsNearTheLargestCoordinate) {
    MeshData ring = scenes::torus(0.5, 0.2, 24, 12);
    const double scale = 1e17;
    for (Vec3f& p : ring.positions) p = static_cast<float>(scale) * p;
    for (const double at : {0.0, 0.99999 * constants::largest_coordinate}) {
        World world(Settings{.coverage = Coverage::complete});
        const MeshId mesh = world.add_mesh("ring", ring);
        const BodyId a = world.add_rigid_body(mesh, {{at - 0.3 * scale, 0, 0}, {}});
        const BodyId b = world.add_rigid_body(mesh, {{at, 0, 0.1 * scale}, {}});
        const std::optional<Parting> parting = world.parting(a, b);
        ASSERT_TRUE(parting);
        Pose there = world.pose_of(a);
        there.position = there.position - parting->translation();
        world.set_pose(a, there);
        world.detect();
        for (const Contact& c : world.contacts())
            EXPECT_LT(c.penetration_depth(), 1e-5 * scale) << at;
    }
}

TEST(PartingTest, SaysWhereBGoesAndChangesNothing) {
    World world;
    const MeshId cube_mesh = world.add_mesh("cube", cube(1)),
                 slab = world.add_mesh("slab", scenes::box({-9, -9, -1}, {9, 9, 0}));
    const BodyId floor = world.add_fixed_body(slab);
    const BodyId above = world.add_rigid_body(cube_mesh, {{0, 0, 0.9}, {}}),
                 apart = world.add_rigid_body(cube_mesh, {{5, 0, 5}, {}});
    const MeshData soft = cube(1);
    std::vector<Vec3f> positions = soft.positions;
    for (Vec3f& p : positions) p.x += 1.75f, p.z += 0.9375f;
    const BodyId beside = world.add_deforming_body(cube_mesh, positions);
    world.detect();
    const std::vector<Contact> before(world.contacts().begin(), world.contacts().end());

    const auto expect = [&](BodyId a, BodyId b, Vec3d direction, double depth) {
        const std::optional<Parting> parting = world.parting(a, b);
        ASSERT_TRUE(parting);
        EXPECT_NEAR(parting->depth, depth, little);
        EXPECT_NEAR(length(parting->direction - direction), 0, 1e-9);
        EXPECT_NEAR(length(parting->translation() - depth * direction), 0, little);
    };
    expect(floor, above, {0, 0, 1}, 0.1);
    expect(above, floor, {0, 0, -1}, 0.1);
    expect(above, beside, {1, 0, 0}, 0.25);
    expect(beside, above, {-1, 0, 0}, 0.25);
    expect(beside, floor, {0, 0, -1}, 0.0625);
    EXPECT_FALSE(world.parting(floor, apart));

    EXPECT_EQ(world.contacts().size(), before.size());
    EXPECT_TRUE(std::ranges::equal(world.contacts(), before, [](const auto& x, const auto& y) {
        return x.feature() == y.feature() && x.distance == y.distance;
    }));
    // Where bodies are now counts, not where the last step saw them.
    world.set_pose(apart, {{0, 0, 0.8}, {}});
    expect(floor, apart, {0, 0, 1}, 0.2);
}

TEST(PartingTest, RefusesWhatHasNoInsideOrIsNotHere) {
    World world;
    const MeshId mesh = world.add_mesh("cube", cube(1));
    const BodyId a = world.add_rigid_body(mesh), b = world.add_deforming_body(mesh);
    EXPECT_THROW(world.parting(a, a), InputError);
    EXPECT_TRUE(world.parting(a, b));
    world.set_pose(a, {{NAN, 0, 0}, {}});
    EXPECT_FALSE(world.parting(a, b));
    world.set_collision(b, {.sheet = true, .thickness = 0.1});
    EXPECT_THROW(world.parting(a, b), InputError);
    world.remove_body(b);
    EXPECT_THROW(world.parting(a, b), InputError);
}

TEST(LeastTranslationTest, MeetsWhatContactsAskFor) {
    World world;
    const MeshId mesh = world.add_mesh("cube", cube(1));
    const BodyId a = world.add_rigid_body(mesh), b = world.add_rigid_body(mesh);
    world.set_pose(b, {{0.5, 0.25, 1.9}, {}});
    world.detect();
    ASSERT_FALSE(world.contacts().empty());
    const std::optional<Parting> way = least_translation(world.contacts());
    ASSERT_TRUE(way);
    EXPECT_NEAR(way->depth, 0.1, 1e-6);
    EXPECT_NEAR(way->direction.z, 1, 1e-12);
    for (const Contact& c : world.contacts())
        EXPECT_GE(dot(c.normal, way->translation()), -c.distance - 1e-7);

    EXPECT_EQ(least_translation({})->depth, 0);
    // Held from opposite sides.
    Contact above, below;
    above.normal = {0, 0, 1};
    below.normal = {0, 0, -1};
    above.distance = below.distance = -0.5;
    EXPECT_FALSE(least_translation(std::vector{above, below}));
    below.unknown_side = true;
    EXPECT_NEAR(least_translation(std::vector{above, below})->depth, 0.5, 1e-7);
    static_cast<void>(a);
}

}  // namespace
}  // namespace pierce::truth
