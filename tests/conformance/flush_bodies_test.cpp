// Bodies that only touch, of many parts or with vertices that have no normal, and blades: no depth
// is made up, and the way out is the short one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/prism.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

class FlushBodiesTest : public testing::TestWithParam<test::NamedBackend> {
protected:
    /// The depth of the deepest contact of two bodies, and their parting.
    struct Depths {
        double contact = 0, parting = 0;
        bool is_in_contact = false;
    };
    Depths depths(const MeshData& fixed, const MeshData& other, const Pose& pose,
                  double margin = 0) const {
        Settings settings;
        settings.margin = margin;
        World world(GetParam().make(), settings);
        const BodyId a = world.add_fixed_body(world.add_mesh("fixed", fixed)),
                     b = world.add_rigid_body(world.add_mesh("other", other), pose);
        world.detect();
        Depths found;
        for (const Contact& c : world.contacts())
            found.contact = std::max(found.contact, -c.distance);
        found.is_in_contact = !world.contacts().empty();
        if (const auto parting = world.parting(a, b)) found.parting = parting->depth;
        return found;
    }
};

MeshData unit_cube(Vec3d corner) { return scenes::box(corner, corner + Vec3d{1, 1, 1}); }

std::vector<Vec3d> cubes_around_one() {
    std::vector<Vec3d> all;
    for (int k = 0; k < 27; ++k)
        if (k != 13) all.push_back({k % 3 - 1.0, k / 3 % 3 - 1.0, k / 9 - 1.0});
    return all;
}

TEST_P(FlushBodiesTest, ACubeAmongCubesThatAreOneMeshOnlyTouches) {
    test::Random random(41);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const MeshData cube = unit_cube({0, 0, 0});
    const std::vector<Vec3d> around = cubes_around_one();
    std::vector<std::vector<Vec3d>> sets = {{{-1, -1, -1}, {-1, -1, 0}, {0, 1, 0}},  // its rays
                                                                                     // once led
                                                                                     // into the
                                                                                     // third
                                            {{-1, -1, -1}, {-1, -1, 0}, {1, 1, 1}}};
    for (int i = 0; i < 40; ++i) {
        std::vector<Vec3d>& some = sets.emplace_back();
        const int share = random.integer(1, 8);
        for (const Vec3d& corner : around)
            if (random.integer(0, 8) < share) some.push_back(corner);
        if (some.empty()) some.push_back(around.front());
    }
    for (const std::vector<Vec3d>& some : sets) {
        MeshData parts;
        for (const Vec3d& corner : some) parts = scenes::joined(parts, unit_cube(corner));
        const Depths found = depths(parts, cube, {});
        EXPECT_EQ(found.contact, 0) << some.size() << " cubes";
        EXPECT_EQ(found.parting, 0) << some.size() << " cubes";
    }
}

TEST_P(FlushBodiesTest, ABodyInThePlaceOfAPartIsAsDeepAsThePart) {
    MeshData parts;
    for (const Vec3d corner : {Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 0, 1}})
        parts = scenes::joined(parts, unit_cube(corner));
    const Depths found = depths(parts, unit_cube({0, 0, 0}), {});
    EXPECT_GE(found.contact, 1);
    EXPECT_GE(found.parting, 1 - 1e-6);
}

/// Three walls of six cubes, which meet at the origin. Their corner there is a saddle: the normals
/// of its triangles cancel.
MeshData three_walls() {
    MeshData mesh;
    for (int k = 0; k < 27; ++k)
        mesh.positions.push_back(to_float(Vec3d{k % 3 - 1.0, k / 3 % 3 - 1.0, k / 9 - 1.0}));
    const auto node = [](int x, int y, int z) {
        return static_cast<std::uint32_t>(x + 3 * y + 9 * z);
    };
    // Of eight cubes, all but the outermost one and the one that the walls surround.
    const auto is_wall = [](int x, int y, int z) {
        return std::min({x, y, z}) >= 0 && std::max({x, y, z}) <= 1 && x + y + z > 0 &&
               x + y + z < 3;
    };
    for (int z = 0; z < 2; ++z)
        for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 2; ++x) {
                if (!is_wall(x, y, z)) continue;
                for (int axis = 0; axis < 3; ++axis)
                    for (const int side : {0, 1}) {
                        int next[3] = {x, y, z};
                        next[axis] += side == 1 ? 1 : -1;
                        if (is_wall(next[0], next[1], next[2])) continue;
                        std::uint32_t corner[4];
                        for (int k = 0; k < 4; ++k) {
                            int place[3] = {x, y, z};
                            place[axis] += side;
                            place[(axis + 1) % 3] += k == 1 || k == 2;
                            place[(axis + 2) % 3] += k >= 2;
                            corner[side == 1 ? k : 3 - k] = node(place[0], place[1], place[2]);
                        }
                        mesh.triangles.push_back({{corner[0], corner[1], corner[2]}});
                        mesh.triangles.push_back({{corner[0], corner[2], corner[3]}});
                    }
            }
    return mesh;
}

TEST_P(FlushBodiesTest, ACubeInACornerWithoutANormalOnlyTouches) {
    const MeshData walls = three_walls(), cube = unit_cube({0, 0, 0});
    for (const double away : {0.0, 1e-9, 1e-7}) {
        const Depths found = depths(walls, cube, {{away, away, away}, {}});
        EXPECT_EQ(found.contact, 0) << away;
        EXPECT_EQ(found.parting, 0) << away;
    }
    const Depths deep = depths(walls, cube, {{-0.01, -0.02, -0.03}, {}});
    EXPECT_NEAR(deep.contact, length(Vec3d{0.01, 0.02, 0}), 1e-6) << "its corner above, out of two";
}

/// A box that is pressed into the top of a blade leaves upwards, however deep it is beside how thin
/// the blade is there, and not along it past its edge.
TEST_P(FlushBodiesTest, ABoxOnABladeIsPushedUp) {
    const MeshData blade{{{0, 0, -0.3f},
                          {1, -0.02f, -0.3f},
                          {1, 0.02f, -0.3f},
                          {0, 0, 0},
                          {1, -0.02f, 0},
                          {1, 0.02f, 0}},
                         {{{0, 2, 1}},
                          {{3, 4, 5}},
                          {{0, 1, 4}},
                          {{0, 4, 3}},
                          {{1, 2, 5}},
                          {{1, 5, 4}},
                          {{2, 0, 3}},
                          {{2, 3, 5}}}};
    const MeshData box = scenes::box({-0.15f, -0.15f, -0.15f}, {0.15f, 0.15f, 0.15f});
    for (const double deep : {0.005, 0.01, 0.02, 0.05})
        for (const double turn : {0.0, 0.4}) {
            const Quaternion around{0, 0, std::sin(turn / 2), std::cos(turn / 2)};
            const Depths found = depths(blade, box, {{0.6, 0, 0.15 - deep}, around});
            EXPECT_NEAR(found.contact, deep, 1e-6) << "turned by " << turn;
            EXPECT_NEAR(found.parting, deep, 1e-6) << "turned by " << turn;
        }
}

// A ray along the floor runs through all of it, but is nowhere deeper than the body.
TEST_P(FlushBodiesTest, WhatStandsBetweenWallsIsNoDeeperThanItIs) {
    const MeshData
        tray = test::prism(
            {{-3, -0.2f, 0},
             {3, -0.2f, 0},
             {3, 2, 0},
             {2.8f, 2, 0},
             {2.8f, 0, 0},
             {-2.8f, 0, 0},
             {-2.8f, 2, 0},
             {-3, 2, 0}},
            {{{0, 1, 4}}, {{0, 4, 5}}, {{1, 2, 4}}, {{2, 3, 4}}, {{0, 5, 7}}, {{5, 6, 7}}}),
        corner = test::prism(
            {{-3, -0.2f, 0}, {3, -0.2f, 0}, {3, 0, 0}, {-2.8f, 0, 0}, {-2.8f, 2, 0}, {-3, 2, 0}},
            {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 5}}, {{3, 4, 5}}}),
        box = scenes::box({-0.2, 0, -0.6}, {0.2, 1.6, 0.6});
    MeshData blade = test::prism({{-0.5f, 0, 0}, {0.5f, 0, 0}, {0.5f, 0.05f, 0}}, {{{0, 1, 2}}});
    for (Vec3f& p : blade.positions) p.z *= 0.5f;
    constexpr double touch = 2e-5;  // more than any pair's touch tolerance
    test::Random random(7);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int at_rest = 0;
    for (int i = 0; i < 400; ++i) {
        const MeshData& target = i % 2 == 0 ? tray : corner;
        const bool is_box = i % 4 < 2;
        const double down = std::pow(10, random.uniform(-8, -3)), tilt = down / 2;
        const Pose pose{{random.uniform(-1, 1), -down, random.uniform(-0.3, 0.3)},
                        {random.uniform(-tilt, tilt), 0, random.uniform(-tilt, tilt), 1}};
        const MeshData& other = is_box ? box : blade;
        double deepest = 0;
        for (const Vec3f p : other.positions)
            deepest = std::max(deepest, -frame_of(pose).to_parent(to_double(p)).y);
        const Depths found = depths(target, other, pose, i % 8 < 4 ? 0 : 0.02);
        // Where nothing else has a depth, a vertex may keep that of its ray, which is long at a
        // sharp edge.
        EXPECT_LE(found.contact, 2 * deepest + (is_box ? touch : 40 * touch)) << i;
        if (is_box) {
            EXPECT_LE(found.parting, 2 * deepest + touch) << i;
        }
        at_rest += found.is_in_contact;
    }
    EXPECT_GT(at_rest, 350);
}

INSTANTIATE_TEST_SUITE_P(Backends, FlushBodiesTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
