// The triangle test and the search for the first crossing: hard cases with exact answers, and
// leaks.
#include "core/geometry/triangle.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/device/view.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/first_crossing.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

struct Found {
    std::uint32_t triangle = no_triangle;
    double t = 0;
    double sign = 0;
};

/// What first_crossing settles on, triangles shown in the given order.
Found find(const MeshData& mesh, Vec3d origin, Vec3d direction, std::uint32_t excluded = no_vertex,
           bool reversed = false) {
    Box box;
    for (Vec3f p : mesh.positions) box.extend(to_double(p));
    const Surface surface{view_of(mesh.positions), view_of(mesh.triangles),
                          constants::touch_tolerance * box.extent()};
    Ray ray;
    ray.origin = origin;
    ray.direction = normalized(direction);
    ray.t_max = 2 * box.extent();
    ray.touch = surface.touch;
    ray.excluded[0] = ray.excluded[1] = excluded;
    const Hit hit = first_crossing(ray, surface, [&](CrossingSearch& search) {
        const std::uint32_t n = surface.triangles.size;
        for (std::uint32_t i = 0; i < n; ++i) search.test(reversed ? n - 1 - i : i);
    });
    if (hit.triangle == no_triangle) return {};
    const Triangle& t = mesh.triangles[hit.triangle];
    const Crossing c = cross_triangle(
        {ray.origin, ray.direction}, to_double(mesh.positions[t.vertex[0]]),
        to_double(mesh.positions[t.vertex[1]]), to_double(mesh.positions[t.vertex[2]]));
    return {hit.triangle, c.t, c.sign};
}

MeshData cube() { return scenes::box({0, 0, 0}, {1, 1, 1}); }

MeshData moved(MeshData mesh, float scale, Vec3f by) {
    for (Vec3f& p : mesh.positions) p = scale * p + by;
    return mesh;
}

TEST(FirstCrossingTest, EdgeDiagonalHit) {
    const Found f = find(cube(), {0.5, 0.5, 0.25}, {0, 0, -1});
    EXPECT_EQ(f.t, 0.25);
    EXPECT_EQ(f.sign, 1);
}

TEST(FirstCrossingTest, VertexFanHit) {
    MeshData octahedron{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                        {{{0, 2, 4}},
                         {{2, 1, 4}},
                         {{1, 3, 4}},
                         {{3, 0, 4}},
                         {{2, 0, 5}},
                         {{1, 2, 5}},
                         {{3, 1, 5}},
                         {{0, 3, 5}}}};
    for (bool reversed : {false, true}) {
        const Found f = find(octahedron, {0, 0, 0.25}, {0, 0, -1}, no_vertex, reversed);
        EXPECT_EQ(f.t, 1.25);
        EXPECT_EQ(f.sign, 1);
        EXPECT_EQ(f.triangle, 4u) << "the smallest of the fan";
    }
}

TEST(FirstCrossingTest, RestingOnTheSurfaceIsAnExitAtZero) {
    const Found f = find(cube(), {0.3, 0.6, 1}, {0, 0, 1});
    EXPECT_EQ(f.t, 0);
    EXPECT_EQ(f.sign, 1);
}

TEST(FirstCrossingTest, CornerKissIsAnExitAtZero) {
    const Found f = find(moved(cube(), 1, {1, 1, 1}), {1, 1, 1}, {-1, -1, -1});
    ASSERT_NE(f.triangle, no_triangle);
    EXPECT_EQ(f.t, 0);
    EXPECT_EQ(f.sign, 1);
}

TEST(FirstCrossingTest, EntryAtTheStartDoesNotCount) {
    const Found f = find(cube(), {1, 1, 1}, {-1, -1, -1});
    EXPECT_NEAR(f.t, std::sqrt(3.0), 1e-15);
    EXPECT_EQ(f.sign, 1);
}

TEST(FirstCrossingTest, SlidingInAFaceTouchesIt) {
    const MeshData mesh = cube();
    const Found f = find(mesh, {0.5, 0, 0.5}, {1, 0, 0});
    ASSERT_NE(f.triangle, no_triangle);
    for (std::uint32_t v : mesh.triangles[f.triangle].vertex) EXPECT_EQ(mesh.positions[v].y, 0);
}

TEST(FirstCrossingTest, AGrazedRidgeIsNoCrossing) {
    const MeshData prism{{{0, 0, 0}, {2, 0, 0}, {1, 0, 1}, {0, 1, 0}, {2, 1, 0}, {1, 1, 1}},
                         {{{0, 1, 2}},
                          {{3, 5, 4}},
                          {{0, 3, 4}},
                          {{0, 4, 1}},
                          {{1, 4, 5}},
                          {{1, 5, 2}},
                          {{0, 2, 5}},
                          {{0, 5, 3}}}};
    EXPECT_EQ(find(prism, {-1, 0.5, 1}, {1, 0, 0}).triangle, no_triangle);
    EXPECT_EQ(find(prism, {-1, 0.5, 0.5}, {1, 0, 0}).sign, -1) << "but the face below it is";
}

TEST(FirstCrossingTest, TrianglesWithoutAreaAreNeverHit) {
    // The bottom's edge (0,0,0)-(1,0,0) is split at its middle on one side only; a triangle without
    // area fills the gap.
    MeshData mesh = cube();
    mesh.positions.push_back({0.5f, 0, 0});
    mesh.triangles[4] = {{0, 8, 5}};
    mesh.triangles.push_back({{8, 1, 5}});
    mesh.triangles.push_back({{0, 1, 8}});
    EXPECT_EQ(find(mesh, {0.5, 0.25, 0.25}, {0, 0, -1}).t, 0.25);
    const Found edge = find(mesh, {0.5, 0.25, 0.25}, {0, -0.25, -0.25});
    EXPECT_EQ(edge.sign, 1);
    EXPECT_NE(edge.triangle, 13u);
    EXPECT_NEAR(edge.t, 0.25 * std::sqrt(2.0), 1e-15);
}

TEST(FirstCrossingTest, NeedleFarAwayIsMissed) {
    const MeshData needle{{{0, 0, 0}, {1, 0, 0}, {0.5f, 1e-6f, 0}}, {{{0, 1, 2}}}};
    EXPECT_EQ(find(needle, {0.5, 0.5, 0x1p-10}, {0, 1, -0x1p-20}).triangle, no_triangle);
}

TEST(FirstCrossingTest, FarFromTheOriginAndAtMicroScale) {
    const double far = 0x1p20;
    EXPECT_EQ(find(moved(cube(), 1, {0x1p20f, 0x1p20f, 0x1p20f}),
                   {far + 0.5, far + 0.5, far + 0.25}, {0, 0, -1})
                  .t,
              0.25);
    const double small = 0x1p-40;
    EXPECT_EQ(find(moved(cube(), 0x1p-40f, {}), {small / 2, small / 2, small / 4}, {0, 0, -1}).t,
              0x1p-42);
    const MeshData slab = scenes::box({-0x1p20, -0x1p20, -8}, {0x1p20, 0x1p20, 0});
    EXPECT_NEAR(find(slab, {1.0 / 3, 1.0 / 7, -4}, {0, 0, 1}).t, 4, 1e-9);
}

TEST(FirstCrossingTest, CoincidentSheetsCancel) {
    MeshData two = cube();
    const MeshData right = moved(cube(), 1, {1, 0, 0});
    for (Triangle t : right.triangles)
        two.triangles.push_back({{t.vertex[0] + 8, t.vertex[1] + 8, t.vertex[2] + 8}});
    two.positions.insert(two.positions.end(), right.positions.begin(), right.positions.end());
    const double third = 1.0f / 3.0f;
    for (bool reversed : {false, true}) {
        const Found f = find(two, {0.5, third, third}, {1, 0, 0}, no_vertex, reversed);
        EXPECT_EQ(f.t, 1.5);
        EXPECT_EQ(f.sign, 1);
    }
}

TEST(FirstCrossingTest, NoLeaksAtVerticesAndEdges) {
    test::Random random(5);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (float offset : {0.0f, 1e5f}) {
        const MeshData ball = moved(scenes::sphere(1, 3), 1, {offset, offset, offset});
        const Vec3d center{offset, offset, offset};
        for (int i = 0; i < 4000; ++i) {
            const Vec3d origin = center + random.in_box(0.3);
            const Triangle& t = ball.triangles[static_cast<std::size_t>(random.integer(0, 1279))];
            const Vec3d a = to_double(ball.positions[t.vertex[0]]),
                        b = to_double(ball.positions[t.vertex[1]]);
            const double part = i % 2 == 0 ? 0.0 : random.uniform(0, 1);
            const Found f = find(ball, origin, (1 - part) * a + part * b - origin);
            ASSERT_NE(f.triangle, no_triangle);
            ASSERT_EQ(f.sign, 1);
        }
    }
}

TEST(FirstCrossingTest, TheOrderOfTrianglesDoesNotMatter) {
    test::Random random(6);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int i = 0; i < 300; ++i) {
        const MeshData mesh = test::random_closed_mesh(random);
        const Vec3d origin = random.in_box(1);
        const Vec3d aim = to_double(mesh.positions[static_cast<std::size_t>(
            random.integer(0, static_cast<int>(mesh.positions.size()) - 1))]);
        EXPECT_EQ(find(mesh, origin, aim - origin).triangle,
                  find(mesh, origin, aim - origin, no_vertex, true).triangle);
    }
}

}  // namespace
}  // namespace pierce
