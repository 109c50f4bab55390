// Triangles without area, such as those that close a T-junction, and vertices without triangles:
// contacts are as without them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/closest_point.hpp"
#include "pierce/contact_hash.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/backends.hpp"
#include "support/prism.hpp"
#include "support/random.hpp"
#include "support/t_junction.hpp"

namespace pierce {
namespace {

constexpr double rounding = 1e-6;

class NoAreaTest : public testing::TestWithParam<test::NamedBackend> {};

/// An L: the edge over corner 3 bends inward.
MeshData bracket() {
    const std::vector<Vec3f> outline = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0},
                                        {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
    return test::prism(outline, {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 5}}, {{3, 4, 5}}});
}

/// With a T-junction on the edges between vertex v and v + n.
MeshData with_t_junctions(MeshData mesh, std::uint32_t n) {
    const std::vector<Triangle> before = mesh.triangles;
    for (std::uint32_t v = 0; v < n; ++v)
        for (std::size_t t = 0; t < before.size(); ++t)
            for (int k = 0; k < 3; ++k)
                if (before[t].vertex[k] == v && before[t].vertex[(k + 1) % 3] == v + n)
                    test::add_t_junction(mesh, t, k, 0.6);
    return mesh;
}

/// A cube of width 2; vertex 8 + k is the middle of a side.
MeshData cube_with_middles() {
    MeshData mesh = scenes::box({-1, -1, -1}, {1, 1, 1});
    const std::vector<Triangle> halves = std::exchange(mesh.triangles, {});
    for (std::size_t side = 0; side < 6; ++side) {
        // The two halves of a side, as a fan around its middle.
        std::vector<std::pair<std::uint32_t, std::uint32_t>> border;
        Vec3d sum;
        const auto add = [&](std::uint32_t from, std::uint32_t to) {
            const auto back = std::ranges::find(border, std::pair{to, from});
            if (back != border.end())
                border.erase(back);
            else
                border.emplace_back(from, to);
        };
        for (const std::size_t half : {2 * side, 2 * side + 1})
            for (int k = 0; k < 3; ++k)
                add(halves[half].vertex[k], halves[half].vertex[(k + 1) % 3]);
        const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
        for (const auto& [from, to] : border) {
            sum += to_double(mesh.positions[from]);
            mesh.triangles.push_back({{from, to, middle}});
        }
        mesh.positions.push_back(to_float(0.25 * sum));
    }
    return mesh;
}

/// Three faces around a tip, and one at the other end, which has a greater y.
MeshData needle(Vec3d tip, Vec3d end) {
    MeshData mesh;
    for (const Vec3d p : {tip, end, end + Vec3d{0.02, 0, 0}, end + Vec3d{0, 0, 0.02}})
        mesh.positions.push_back(to_float(p));
    mesh.triangles = {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 1}}, {{1, 3, 2}}};
    return mesh;
}

MeshData turned(MeshData mesh, const Pose& pose) {
    for (Vec3f& p : mesh.positions) p = to_float(frame_of(pose).to_parent(to_double(p)));
    return mesh;
}

/// The least distance to a triangle with area.
double distance_to(const MeshData& mesh, Vec3d p) {
    double least = INFINITY;
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a = to_double(mesh.positions[t.vertex[0]]),
                    b = to_double(mesh.positions[t.vertex[1]]),
                    c = to_double(mesh.positions[t.vertex[2]]);
        if (length(cross(b - a, c - a)) > 1e-4)
            least = std::min(least, length(p - closest_on_triangle(p, a, b, c)));
    }
    return least;
}

TEST_P(NoAreaTest, VerticesInsideEndAtTheClosestPlaceBesideAReentrantEdge) {
    test::Random random(41);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int inside = 0;
    for (int i = 0; i < 60; ++i) {
        const Pose turn{random.in_box(0.3), random.rotation()};
        const MeshData target = turned(with_t_junctions(bracket(), 6), turn);
        World world(GetParam().make());
        const MeshId mesh = world.add_mesh("bracket", target);
        ASSERT_EQ(world.mesh(mesh).traits().degenerate_triangles, 6u);
        if (i % 2 == 0)
            world.add_fixed_body(mesh);
        else
            world.add_deforming_body(mesh);
        // A tip near the middle of the edge that bends inward, inside.
        const Vec3d tip{random.uniform(0.75, 0.85), random.uniform(0.75, 0.85),
                        random.uniform(-0.5, 0.5)};
        const MeshData probe = turned(needle(tip, {1.8, 1.9, 0}), turn);
        world.add_rigid_body(world.add_mesh("probe", probe));
        world.detect();
        for (const Contact& c : world.contacts()) {
            if (c.is_edge() || c.found == Found::separation || c.source != Side::b) continue;
            ++inside;
            EXPECT_TRUE(c.reprojected) << i;
            EXPECT_NEAR(c.penetration_depth(), distance_to(target, c.source_point()), rounding)
                << i;
        }
    }
    EXPECT_GE(inside, 60);
}

TEST_P(NoAreaTest, VerticesNearATJunctionAreWithinTheMargin) {
    test::Random random(42);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t near = 0;
    for (int i = 0; i < 60; ++i) {
        const Pose turn{random.in_box(0.3), random.rotation()};
        const MeshData target = turned(with_t_junctions(bracket(), 6), turn);
        World world(GetParam().make(), {.margin = 0.5});
        const MeshId mesh = world.add_mesh("bracket", target);
        if (i % 2 == 0)
            world.add_fixed_body(mesh);
        else
            world.add_deforming_body(mesh);
        const MeshData probe = scenes::sphere(0.05, 0);
        const Vec3d place = frame_of(turn).to_parent({2.15 + random.uniform(-0.05, 0.1),
                                                      1.15 + random.uniform(-0.05, 0.1),
                                                      random.uniform(-0.8, 0.8)});
        const Pose pose{place, random.rotation()};
        const BodyId body = world.add_rigid_body(world.add_mesh("probe", probe), pose);
        world.detect();
        for (std::uint32_t v = 0; v < probe.positions.size(); ++v) {
            const double distance = distance_to(target, world.vertex_position(body, v));
            ASSERT_LT(distance, 0.49);
            const auto found = std::ranges::find_if(world.contacts(), [&](const Contact& c) {
                return c.source == Side::b && !c.is_edge() && c.vertex == v;
            });
            ASSERT_NE(found, world.contacts().end()) << i << " vertex " << v;
            EXPECT_NEAR(found->distance, distance, rounding) << i << " vertex " << v;
            ++near;
        }
    }
    EXPECT_GT(near, 300u);
}

/// A triangle without area that comes with the motion of a body is one, too.
TEST_P(NoAreaTest, VerticesNearAFaceWhoseTrianglesCollapseAreWithinTheMargin) {
    test::Random random(44);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int near = 0;
    for (int i = 0; i < 200; ++i) {
        // A cube whose sides have a vertex in their middles, one of which slides onto a border.
        const MeshData rest = cube_with_middles();
        const Pose turn{random.in_box(0.3), random.rotation()};
        MeshData now = rest;
        const auto side = static_cast<std::size_t>(random.integer(0, 5));
        Vec3f& middle = now.positions[8 + side];
        int axis = 0;
        while (std::abs(middle[axis]) != 1) ++axis;
        middle[(axis + 1) % 3] = 1;
        middle[(axis + 2) % 3] = static_cast<float>(random.uniform(-0.9, 0.9));
        now = turned(now, turn);
        // Beside the border and beyond both of its faces.
        Vec3d place;
        place[axis] = rest.positions[8 + side][axis] * random.uniform(0.98, 1.03);
        place[(axis + 1) % 3] = random.uniform(1.005, 1.03);
        place[(axis + 2) % 3] = random.uniform(-0.9, 0.9);
        World world(GetParam().make(), {.margin = 0.2});
        world.add_deforming_body(world.add_mesh("cube", rest), now.positions);
        const MeshData probe = scenes::sphere(0.001, 0);
        const BodyId body = world.add_rigid_body(world.add_mesh("probe", probe),
                                                 {frame_of(turn).to_parent(place), {}});
        world.detect();
        for (std::uint32_t v = 0; v < probe.positions.size(); ++v) {
            const double distance = distance_to(now, world.vertex_position(body, v));
            const auto found = std::ranges::find_if(world.contacts(), [&](const Contact& c) {
                return c.source == Side::b && !c.is_edge() && c.vertex == v;
            });
            ASSERT_NE(found, world.contacts().end()) << i << " vertex " << v;
            EXPECT_NEAR(found->distance, distance, rounding) << i << " vertex " << v;
            ++near;
        }
    }
    EXPECT_GT(near, 1000);
}

TEST_P(NoAreaTest, RidgesCutByTJunctionsAreWithinTheMargin) {
    test::Random random(43);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int i = 0; i < 60; ++i) {
        // Two bars cross, a ridge of each towards the other: one contact of edges.
        const MeshData bar = test::prism({{0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}},
                                         {{{0, 1, 2}}, {{0, 2, 3}}});
        const Pose turn{{}, random.rotation()};
        const double apart = random.uniform(0.02, 0.1);
        const Pose over{{2 + apart, 0, 0}, {std::sqrt(0.5), 0, 0, std::sqrt(0.5)}};
        const auto edges_near = [&](bool is_cut) {
            const MeshData one = is_cut ? with_t_junctions(bar, 4) : bar;
            World world(GetParam().make(), {.margin = 0.2});
            const MeshId mesh = world.add_mesh("bar", turned(one, turn)),
                         other = world.add_mesh("over", turned(turned(one, over), turn));
            if (i % 2 == 0) {
                world.add_fixed_body(mesh);
                world.add_rigid_body(other);
            } else {
                world.add_deforming_body(mesh);
                world.add_deforming_body(other);
            }
            world.detect();
            std::vector<Contact> found;
            std::ranges::copy_if(world.contacts(), std::back_inserter(found),
                                 [](const Contact& c) { return c.is_edge(); });
            return found;
        };
        const std::vector<Contact> whole = edges_near(false), cut = edges_near(true);
        ASSERT_EQ(whole.size(), 1u) << i;
        ASSERT_EQ(cut.size(), 1u) << i;
        EXPECT_NEAR(cut[0].distance, apart, rounding) << i;
        EXPECT_NEAR(length(cut[0].point_a - whole[0].point_a), 0, 1e-4) << i;
    }
}

/// A triangle without area that floats beside the surface hides nothing of it.
TEST_P(NoAreaTest, WhatFloatsIsNotTheClosestPlace) {
    MeshData cube = scenes::box({-1, -1, -1}, {1, 1, 1});
    const auto first = static_cast<std::uint32_t>(cube.positions.size());
    for (const float x : {-0.3f, 0.0f, 0.3f}) cube.positions.push_back({x, 0, 1.05f});
    cube.triangles.push_back({{first, first + 1, first + 2}});
    cube.triangles.push_back({{first, first + 2, first + 1}});
    World world(GetParam().make(), {.margin = 0.3});
    world.add_fixed_body(world.add_mesh("cube", cube));
    const MeshData probe = scenes::sphere(0.05, 0);
    const BodyId body = world.add_rigid_body(world.add_mesh("probe", probe), {{0, 0, 1.15}, {}});
    world.detect();
    std::size_t found = 0;
    for (const Contact& c : world.contacts()) {
        if (c.is_edge() || c.source != Side::b) continue;
        EXPECT_NEAR(c.distance, world.vertex_position(body, c.vertex).z - 1, rounding);
        ++found;
    }
    EXPECT_EQ(found, probe.positions.size());
}

/// Contacts do not depend on a vertex without triangles, wherever it is.
TEST_P(NoAreaTest, VerticesWithoutTrianglesAreNoPartOfABody) {
    const MeshData plain = scenes::torus(1, 0.4, 18, 10);
    for (const bool deforms : {false, true})
        for (const double spread : {0.02, 0.9}) {
            std::vector<std::uint64_t> hashes;
            for (const float far : {0.0f, 3.0f, 1e3f, 1e7f}) {
                MeshData mesh = plain;
                if (far > 0) mesh.positions.push_back({far, 0, far});
                World world(GetParam().make(), {.coverage = Coverage::complete});
                const MeshId id = world.add_mesh("torus", mesh);
                for (int b = 0; b < 3; ++b) {
                    const Pose pose{{spread * b, 0.3 * spread * b, 0.1 * b}, {}};
                    if (deforms)
                        world.add_deforming_body(id, test::placed(mesh, pose));
                    else
                        world.add_rigid_body(id, pose);
                }
                for (int step = 0; step < 2; ++step) world.detect();
                EXPECT_GT(world.contacts().size(), 20u);
                hashes.push_back(contact_hash(world.contacts()));
                EXPECT_EQ(hashes.back(), hashes.front()) << deforms << " " << spread << " " << far;
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Backends, NoAreaTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
