// The exact truth that methods are measured against: on cases with known answers, and against plain
// long double.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/closest_point.hpp"
#include "pierce/error.hpp"
#include "support/brute_force.hpp"
#include "support/random.hpp"
#include "truth/cubes.hpp"
#include "truth/exact_mesh.hpp"
#include "truth/minimum_translation.hpp"

namespace pierce::truth {
namespace {

using scenes::box;
using scenes::sphere;
using scenes::torus;
using testing::HasSubstr;
using testing::ThrowsMessage;

ExactMesh exact(const MeshData& mesh) { return {in_double(mesh.positions), mesh.triangles}; }

Frame shifted(Vec3d by) { return {{}, by}; }

MeshData joined(MeshData a, const MeshData& b) {
    const auto first = static_cast<std::uint32_t>(a.positions.size());
    a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
    for (const Triangle& t : b.triangles)
        a.triangles.push_back({{t.vertex[0] + first, t.vertex[1] + first, t.vertex[2] + first}});
    return a;
}

MeshData inside_out(MeshData mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t.vertex[0], t.vertex[1]);
    return mesh;
}

TEST(ExactMeshTest, PointsInOnAndOutOfACube) {
    const ExactMesh mesh = exact(cube(1));
    EXPECT_TRUE(mesh.closed());
    EXPECT_EQ(mesh.where({0, 0, 0}), Where::inside);
    EXPECT_EQ(mesh.where({1 - 1e-15, 0.3, -0.2}), Where::inside);
    EXPECT_EQ(mesh.where({1 + 1e-15, 0.3, -0.2}), Where::outside);
    for (Vec3d p : {Vec3d{1, 0.3, -0.2}, Vec3d{1, 1, 0.5}, Vec3d{-1, -1, -1}, Vec3d{1, 0, 0}})
        EXPECT_EQ(mesh.where(p), Where::on) << p.x << ' ' << p.y << ' ' << p.z;
    EXPECT_EQ(mesh.where({NAN, 0, 0}), Where::outside);

    const Nearest nearest = mesh.nearest({0.75, 0.25, -0.5});
    EXPECT_EQ(nearest.point, (Vec3d{1, 0.25, -0.5}));
    EXPECT_EQ(nearest.distance, 0.25);
    const Triangle t = cube(1).triangles[nearest.triangle];
    for (std::uint32_t v : t.vertex) EXPECT_EQ(mesh.positions()[v].x, 1);
}

TEST(ExactMeshTest, TouchingCubesIntersectAndCubesAnUlpApartDoNot) {
    const ExactMesh a = exact(cube(1));
    const double ulp = std::nextafter(2.0, 3.0) - 2.0;
    for (Vec3d touching : {Vec3d{2, 0.5, 0.5}, Vec3d{2, 2, 0.5}, Vec3d{2, 2, 2}, Vec3d{0, 0, 0}}) {
        EXPECT_TRUE(a.surfaces_intersect(a, shifted(touching)));
        EXPECT_TRUE(a.overlaps(a, shifted(touching)));
        EXPECT_FALSE(a.contains_part(a, shifted(touching)));
    }
    EXPECT_FALSE(a.overlaps(a, shifted({2 + ulp, 0.5, 0.5})));
    EXPECT_FALSE(a.overlaps(a, shifted({2 + ulp, 2, 2})));
    const Frame turned = frame_of(
        {{1 + std::sqrt(2.0) - 1e-9, 0, 0}, {0, 0, std::sin(M_PI / 8), std::cos(M_PI / 8)}});
    EXPECT_TRUE(a.overlaps(a, turned));
    EXPECT_FALSE(a.overlaps(a, {turned.rotation, turned.origin + Vec3d{2e-9, 0, 0}}));
}

TEST(ExactMeshTest, ACubeInACubeOverlapsWithoutMeetingIt) {
    const ExactMesh big = exact(box({-1, -2, -2}, {4, 2, 2})), small = exact(cube(0.5));
    const Frame placement = shifted({3, -1, 1});
    EXPECT_FALSE(big.surfaces_intersect(small, placement));
    EXPECT_TRUE(big.contains_part(small, placement));
    EXPECT_FALSE(small.contains_part(big, placement.inverse()));
    EXPECT_TRUE(big.overlaps(small, placement));
    EXPECT_TRUE(small.overlaps(big, placement.inverse()));
}

TEST(ExactMeshTest, TheHoleOfATorusIsOutside) {
    const ExactMesh ring = exact(torus(1, 0.25, 40, 16)), ball = exact(sphere(0.5, 2));
    EXPECT_EQ(ring.where({0, 0, 0}), Where::outside);
    EXPECT_EQ(ring.where({0, 1, 0}), Where::inside);
    EXPECT_FALSE(ring.overlaps(ball));
    EXPECT_TRUE(ring.overlaps(ball, shifted({0.3, 0, 0})));
    EXPECT_NEAR(ring.nearest({0, 0, 0}).distance, 0.75, 0.01);
}

TEST(ExactMeshTest, PartsAreLookedAtOneByOne) {
    const ExactMesh two = exact(joined(box({0, 0, 0}, {1, 1, 1}), box({3, 0, 0}, {4, 1, 1})));
    EXPECT_EQ(two.where({0.5, 0.5, 0.5}), Where::inside);
    EXPECT_EQ(two.where({2, 0.5, 0.5}), Where::outside);
    EXPECT_EQ(two.where({3.5, 0.5, 0.5}), Where::inside);
    EXPECT_TRUE(exact(box({2.5, -1, -1}, {4.5, 2, 2})).overlaps(two));
    EXPECT_FALSE(exact(box({1.5, -1, -1}, {2.5, 2, 2})).overlaps(two));

    const ExactMesh hollow = exact(joined(cube(2), inside_out(cube(1)))), speck = exact(cube(0.25));
    EXPECT_EQ(hollow.where({0, 0, 0}), Where::outside);
    EXPECT_EQ(hollow.where({1.5, 0, 0}), Where::inside);
    EXPECT_FALSE(hollow.overlaps(speck));
    EXPECT_TRUE(hollow.overlaps(speck, shifted({1.5, 0, 0})));

    const ExactMesh twice = exact(joined(cube(2), cube(1)));
    EXPECT_EQ(twice.where({0, 0, 0}), Where::inside);
    EXPECT_EQ(exact(inside_out(cube(1))).where({0, 0, 0}), Where::inside);
}

TEST(ExactMeshTest, TrianglesWithoutAreaDoNoHarm) {
    MeshData mesh = cube(1);
    const auto [a, b, c] = mesh.triangles[0].vertex;
    mesh.positions.push_back(0.5f * (mesh.positions[a] + mesh.positions[b]));
    const std::uint32_t middle = 8;
    mesh.triangles[0] = {{a, middle, c}};
    for (const Triangle& t : {Triangle{{middle, b, c}}, Triangle{{a, b, middle}},
                              Triangle{{a, a, b}}, Triangle{{b, a, a}}, Triangle{{c, c, c}}})
        mesh.triangles.push_back(t);
    const ExactMesh split = exact(mesh);
    EXPECT_TRUE(split.closed());
    EXPECT_EQ(split.where({0, 0, 0}), Where::inside);
    EXPECT_EQ(split.where({3, 0, 0}), Where::outside);
    EXPECT_EQ(split.where(to_double(mesh.positions[middle])), Where::on);
    EXPECT_EQ(split.nearest({0, 0, 3}).distance, 2);
    EXPECT_TRUE(split.overlaps(exact(cube(0.5))));
    EXPECT_TRUE(exact(cube(1)).surfaces_intersect(split, shifted({1, 1, 1})));

    const ExactMesh nothing = exact({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{{0, 1, 2}}}});
    EXPECT_EQ(nothing.where({1, 0, 0}), Where::outside);
    EXPECT_EQ(nothing.nearest({1, 0, 0}).distance, INFINITY);
    EXPECT_FALSE(nothing.overlaps(split));
    EXPECT_FALSE(split.surfaces_intersect(nothing));
}

TEST(ExactMeshTest, AnOpenMeshHasNoInside) {
    const ExactMesh open = exact(open_cube()), small = exact(cube(0.5));
    EXPECT_FALSE(open.closed());
    EXPECT_EQ(open.where({0, 0, 0}), Where::outside);
    EXPECT_EQ(open.where({-1, -1, -1}), Where::on);
    EXPECT_FALSE(open.overlaps(small));
    EXPECT_FALSE(exact(cube(2)).overlaps(open));
    EXPECT_TRUE(open.overlaps(small, shifted({-1, 0, 0})));
}

TEST(ExactMeshTest, BadMeshesAreRefused) {
    const std::vector<Vec3d> bad{{0, 0, 0}, {1, 0, 0}, {0, INFINITY, 0}},
        good{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const std::vector<Triangle> one{{{0, 1, 2}}}, missing{{{0, 1, 3}}};
    EXPECT_THAT([&] { ExactMesh(bad, one); },
                ThrowsMessage<InputError>(HasSubstr("position 2 is not finite")));
    EXPECT_THAT([&] { ExactMesh(good, missing); },
                ThrowsMessage<InputError>(HasSubstr("triangle 0 names vertex 3 of 3")));
}

test::Solid solid(const std::vector<Vec3d>& positions, const std::vector<Triangle>& triangles) {
    test::Solid result{{}, triangles};
    for (Vec3d p : positions) result.positions.push_back({p.x, p.y, p.z});
    return result;
}

TEST(ExactMeshTest, AgreesWithBruteForceOnRandomMeshes) {
    test::Random random(41);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    int inside = 0, outside = 0;
    for (int i = 0; i < 40; ++i) {
        const MeshData mesh = test::random_closed_mesh(random);
        const std::vector<Vec3d> positions = in_double(
            test::placed(mesh, {random.in_box(3), random.rotation()}));
        const ExactMesh truth(positions, mesh.triangles);
        const test::Solid expected = solid(positions, mesh.triangles);
        for (int k = 0; k < 30; ++k) {
            const Vec3d p = truth.box().center() + random.in_box(1);
            double distance = INFINITY;
            for (const Triangle& t : mesh.triangles)
                distance = std::min(distance,
                                    length(p - closest_on_triangle(p, positions[t.vertex[0]],
                                                                   positions[t.vertex[1]],
                                                                   positions[t.vertex[2]])));
            const Nearest nearest = truth.nearest(p);
            EXPECT_NEAR(nearest.distance, distance, 1e-13);
            const auto& v = mesh.triangles[nearest.triangle].vertex;
            EXPECT_NEAR(length(p - closest_on_triangle(p, positions[v[0]], positions[v[1]],
                                                       positions[v[2]])),
                        distance, 1e-13);
            if (distance < 1e-9) continue;
            const bool is_inside = test::is_inside({p.x, p.y, p.z}, expected);
            ++(is_inside ? inside : outside);
            EXPECT_EQ(truth.where(p), is_inside ? Where::inside : Where::outside);
        }
    }
    EXPECT_GT(inside, 100);
    EXPECT_GT(outside, 100);
}

/// True if an edge of `a` crosses a triangle of `b`.
bool edges_cross(const test::Solid& a, const test::Solid& b) {
    return std::ranges::any_of(a.triangles, [&](const Triangle& t) {
        for (int k = 0; k < 3; ++k)
            if (test::crossings_between(a.positions[t.vertex[k]],
                                        a.positions[t.vertex[(k + 1) % 3]], b, ~0u, 0) > 0)
                return true;
        return false;
    });
}

TEST(ExactMeshTest, OverlapsAgreeWithBruteForceOnRandomMeshes) {
    test::Random random(42);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    int meeting = 0, contained = 0, apart = 0;
    for (int i = 0; i < 60; ++i) {
        const MeshData a = test::random_closed_mesh(random);
        MeshData b = test::random_closed_mesh(random);
        const auto size = static_cast<float>(random.uniform(0.2, 1));
        for (Vec3f& p : b.positions) p = size * p;
        const Frame placement = frame_of(
            {random.uniform(0, 2) * random.unit_vector(), random.rotation()});
        const std::vector<Vec3d> a_positions = in_double(a.positions);
        std::vector<Vec3d> b_positions = in_double(b.positions);
        for (Vec3d& p : b_positions) p = placement.to_parent(p);
        const test::Solid a_solid = solid(a_positions, a.triangles),
                          b_solid = solid(b_positions, b.triangles);
        const bool meet = edges_cross(a_solid, b_solid) || edges_cross(b_solid, a_solid);
        const bool contains = !meet && (test::is_inside(b_solid.positions[0], a_solid) ||
                                        test::is_inside(a_solid.positions[0], b_solid));
        ++(meet ? meeting : contains ? contained : apart);
        EXPECT_EQ(exact(a).surfaces_intersect(exact(b), placement), meet);
        EXPECT_EQ(exact(b).surfaces_intersect(exact(a), placement.inverse()), meet);
        EXPECT_EQ(exact(a).overlaps(exact(b), placement), meet || contains);
    }
    for (int count : {meeting, contained, apart}) EXPECT_GT(count, 0);
}

/// What minimum_translation says about `b` against `a`.
Translation separation(const MeshData& a, const MeshData& b) {
    const std::vector<Vec3d> a_positions = in_double(a.positions),
                             b_positions = in_double(b.positions);
    return minimum_translation({a_positions, a.triangles}, {b_positions, b.triangles});
}

TEST(MinimumTranslationTest, OfBoxes) {
    const Translation cubes = separation(cube(1), box({0.75, -0.5, -0.5}, {2.75, 1.5, 1.5}));
    EXPECT_DOUBLE_EQ(cubes.length, 0.25);
    EXPECT_EQ(cubes.direction, (Vec3d{1, 0, 0}));

    const Translation plate = separation(cube(2), box({-1, -1, 0}, {1, 1, 0.01}));
    EXPECT_DOUBLE_EQ(plate.length, 2);
    EXPECT_EQ(plate.direction, (Vec3d{0, 0, 1}));

    const MeshData along_x = box({-2, -0.1, -0.1}, {2, 0.1, 0.1}),
                   along_y = box({-0.1, -2, 0}, {0.1, 2, 0.2});
    const Translation bars = separation(along_x, along_y);
    EXPECT_NEAR(bars.length, 0.1, 1e-7);
    EXPECT_EQ(bars.direction, (Vec3d{0, 0, 1}));
    for (Vec3f p : along_x.positions) EXPECT_NE(exact(along_y).where(to_double(p)), Where::inside);
    for (Vec3f p : along_y.positions) EXPECT_NE(exact(along_x).where(to_double(p)), Where::inside);
    EXPECT_TRUE(exact(along_x).overlaps(exact(along_y)));

    EXPECT_LT(separation(cube(1), box({3, 0, 0}, {4, 1, 1})).length, 0);
}

TEST(MinimumTranslationTest, EdgesAgainstEdges) {
    // Two cubes, each turned onto an edge, crossing at right angles: the edges are closest.
    MeshData a = cube(1), b = cube(1);
    const auto h = static_cast<float>(std::sqrt(0.5));
    for (Vec3f& p : a.positions) p = {p.x, h * (p.y - p.z), h * (p.y + p.z)};
    for (Vec3f& p : b.positions) p = {h * (p.x - p.z), p.y, h * (p.x + p.z) + 2.5f};
    const Translation out = separation(a, b);
    EXPECT_NEAR(out.length, 2 * std::sqrt(2.0) - 2.5, 1e-6);
    EXPECT_NEAR(out.direction.z, 1, 1e-12);
}

TEST(MinimumTranslationTest, NoOtherDirectionIsShorter) {
    test::Random random(44);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    const std::vector<Triangle> faces{{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}};
    int overlapping = 0;
    for (int i = 0; i < 100; ++i) {
        std::vector<Vec3d> a, b;
        for (int k = 0; k < 4; ++k) {
            a.push_back(random.in_box(1));
            b.push_back(random.in_box(1));
        }
        const Translation out = minimum_translation({a, faces}, {b, faces}),
                          back = minimum_translation({b, faces}, {a, faces});
        EXPECT_EQ(out.length > 0, back.length > 0);
        if (out.length <= 0) continue;
        ++overlapping;
        EXPECT_NEAR(out.length, back.length, 1e-14);
        EXPECT_NEAR(length(out.direction + back.direction), 0, 1e-14);
        for (int k = 0; k < 200; ++k) {
            const Vec3d u = normalized(out.direction + random.uniform(0, 1) * random.unit_vector());
            double from_a = -INFINITY, from_b = -INFINITY;
            for (Vec3d p : a) from_a = std::max(from_a, dot(p, u));
            for (Vec3d p : b) from_b = std::max(from_b, -dot(p, u));
            EXPECT_GE(from_a + from_b, out.length - 1e-14);
        }
    }
    EXPECT_GT(overlapping, 10);
}

TEST(MinimumTranslationTest, OfSpheresIsTheOverlapAndJustSeparates) {
    test::Random random(43);
    SCOPED_TRACE("PIERCE_TEST_SEED=" + std::to_string(random.seed()));
    const MeshData ball = sphere(1, 2);
    const std::vector<Vec3d> positions = in_double(ball.positions);
    const ExactMesh exact_ball = exact(ball);
    for (int i = 0; i < 3; ++i) {
        const Frame placement = frame_of(
            {random.uniform(1, 1.9) * random.unit_vector(), random.rotation()});
        std::vector<Vec3d> moved = positions;
        for (Vec3d& p : moved) p = placement.to_parent(p);
        const Translation out = minimum_translation({positions, ball.triangles},
                                                    {moved, ball.triangles});
        const double overlap = 2 - length(placement.origin);
        EXPECT_LE(out.length, overlap);
        EXPECT_GT(out.length, overlap - 0.08) << "two tessellation errors";
        for (double part : {1 - 1e-9, 1 + 1e-9})
            EXPECT_EQ(exact_ball.overlaps(exact_ball,
                                          {placement.rotation,
                                           placement.origin + part * out.length * out.direction}),
                      part < 1);
    }
}

}  // namespace
}  // namespace pierce::truth
