// Walks over surfaces, what proves that they ended at the first crossing, and how far bodies move.
#include "core/trace/surface_walk.hpp"

#include <gtest/gtest.h>

#include "core/device/view.hpp"
#include "core/geometry/closest_point.hpp"
#include "core/geometry/motion_bound.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/first_crossing.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

Hit traced(const MeshView& mesh, View<const Vec3f> positions, Ray ray) {
    ray.touch = constants::touch_tolerance * mesh.box.extent();
    const Surface surface{positions, mesh.triangles, ray.touch};
    return first_crossing(ray, surface, [&](CrossingSearch& search) {
        for (std::uint32_t t = 0; t < surface.triangles.size; ++t) search.test(t);
    });
}

Vec3d corner_of(const MeshView& mesh, View<const Vec3f> positions, std::uint32_t t, int k) {
    return to_double(positions[mesh.triangles[t].vertex[k]]);
}

TEST(WalkTest, FindsTheTriangleFromNearby) {
    test::Random random(11);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const Mesh ball("ball", scenes::sphere(1, 3));
    const MeshView mesh = ball.view();
    for (int i = 0; i < 2000; ++i) {
        Ray ray;
        ray.origin = random.in_box(0.3);
        ray.direction = random.unit_vector();
        ray.t_max = 9;
        const std::uint32_t expected = traced(mesh, mesh.positions, ray).triangle;
        // Two steps away.
        std::uint32_t start = expected;
        for (int s = 0; s < 2; ++s) start = mesh.neighbors[start].across[random.integer(0, 2)];
        const WalkEnd end = walk(mesh, mesh.positions, {ray.origin, ray.direction}, start,
                                 constants::walk_steps);
        ASSERT_EQ(end.kind, WalkEnd::found);
        ASSERT_EQ(end.triangle, expected);
        ASSERT_LE(end.steps, 6u);
    }
}

TEST(WalkTest, B1StopsAtABorder) {
    MeshData sheet{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{{0, 1, 2}}, {{0, 2, 3}}}};
    const Mesh open("sheet", sheet);
    const WalkEnd end = walk(open.view(), open.view().positions, {{3, 0.5, 1}, {0, 0, -1}}, 1,
                             constants::walk_steps);
    EXPECT_EQ(end.kind, WalkEnd::boundary);
    EXPECT_EQ(end.triangle, 0u);
}

TEST(WalkTest, B2StopsOnATriangleSeenEdgeOn) {
    const Mesh box("box", scenes::box({0, 0, 0}, {1, 1, 1}));
    const MeshView mesh = box.view();
    for (std::uint32_t t = 0; t < mesh.triangles.size; ++t) {
        const Vec3d a = corner_of(mesh, mesh.positions, t, 0),
                    b = corner_of(mesh, mesh.positions, t, 1);
        // Along an edge of the triangle, off to the side in its plane.
        const Vec3d c = corner_of(mesh, mesh.positions, t, 2);
        const WalkEnd end = walk(mesh, mesh.positions, {c + 2.0 * (c - a), normalized(b - a)}, t,
                                 constants::walk_steps);
        EXPECT_EQ(end.kind, WalkEnd::edge_on);
    }
}

TEST(WalkTest, B3StopsOnADegenerateTriangle) {
    MeshData flat = scenes::box({0, 0, 0}, {1, 1, 1});
    const Mesh box("box", flat);
    for (std::uint32_t v : flat.triangles[0].vertex)
        flat.positions[v] = {0, 0, 0};  // it has degenerated since
    const WalkEnd end = walk(box.view(), view_of(std::as_const(flat.positions)),
                             {{0.2, 0.3, 0.5}, {0, 0, -1}}, 0, constants::walk_steps);
    EXPECT_EQ(end.kind, WalkEnd::edge_on);
}

TEST(WalkTest, B5ALineInTheSheetsPlaneMeetsNothing) {
    test::Random random(55);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const auto in_plane = [](int axis, double u, double v) {
        return axis == 0 ? Vec3d{0.5, u, v} : axis == 1 ? Vec3d{v, 0.5, u} : Vec3d{u, v, 0.5};
    };
    for (int i = 0; i < 60; ++i) {
        MeshData sheet;
        for (int k = 0; k < 16; ++k)
            sheet.positions.push_back(to_float(
                in_plane(i % 3, k % 4 + random.uniform(0, 0.4), k / 4 + random.uniform(0, 0.4))));
        for (std::uint32_t k = 0; k < 11; ++k) {
            if (k % 4 == 3) continue;
            sheet.triangles.push_back({{k, k + 1, k + 5}});
            sheet.triangles.push_back({{k, k + 5, k + 4}});
        }
        const Mesh cloth("cloth", sheet);
        const MeshView mesh = cloth.view();
        Ray ray;
        ray.origin = in_plane(i % 3, -1, random.uniform(-1, 4));
        ray.direction = normalized(in_plane(i % 3, 2, random.uniform(0, 3)) - ray.origin);
        ray.t_max = 9;
        EXPECT_EQ(traced(mesh, mesh.positions, ray).triangle, no_triangle);
        for (std::uint32_t t = 0; t < mesh.triangles.size; ++t)
            EXPECT_EQ(
                walk(mesh, mesh.positions, {ray.origin, ray.direction}, t, constants::walk_steps)
                    .kind,
                WalkEnd::edge_on);
    }
}

TEST(WalkTest, GivesUpAfterTheLastStepAndAtASilhouette) {
    const Mesh ball("ball", scenes::sphere(1, 3));
    const MeshView mesh = ball.view();
    Ray ray{{0, 0, 0}, {0, 0.1, 0.99}, 9};
    ray.direction = normalized(ray.direction);
    const std::uint32_t goal = traced(mesh, mesh.positions, ray).triangle;
    const ShearedRay line(ray.origin, ray.direction);
    const std::uint32_t far = traced(mesh, mesh.positions, {{0, 0, 0}, {0.6, 0, 0.8}, 9}).triangle;
    ASSERT_NE(far, goal);
    EXPECT_EQ(walk(mesh, mesh.positions, line, far, 0).kind, WalkEnd::step_limit);
    // A line beside the ball passes over its horizon again and again.
    const WalkEnd beside = walk(mesh, mesh.positions,
                                {{3, 0.123, 0}, normalized(Vec3d{0.01, 0.02, 1})}, goal, 100);
    EXPECT_EQ(static_cast<int>(beside.kind), static_cast<int>(WalkEnd::silhouette)) << beside.steps;
}

/// A ball with vertices pulled close to a neighbour: slivers, which small movements turn over.
MeshData ball_with_slivers(test::Random& random) {
    MeshData mesh = scenes::sphere(1, 2);
    for (int i = 0; i < 25; ++i) {
        const Triangle& t = mesh.triangles[static_cast<std::size_t>(random.integer(0, 319))];
        Vec3f& p = mesh.positions[t.vertex[0]];
        p = p + 0.93f * (mesh.positions[t.vertex[1]] - p);
    }
    return mesh;
}

/// The proof behind certified walks, against tracing everything: also with vertices moved by a
/// known deviation.
TEST(WalkTest, TheOnlyCrossingIsWhatATracerFinds) {
    test::Random random(12);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int proved = 0, behind = 0, in_front = 0, tried = 0;
    for (int m = 0; m < 120; ++m) {
        const Mesh shape("any",
                         m % 4 == 3 ? ball_with_slivers(random) : test::random_closed_mesh(random));
        const MeshView mesh = shape.view();
        const double touch = constants::touch_tolerance * mesh.box.extent();
        const double deviation = m % 2 == 0 ? 0 : random.uniform(0, 0.1);
        std::vector<Vec3f> moved;
        for (Vec3f p : shape.positions())
            moved.push_back(to_float(to_double(p) + deviation * 0.57 * random.in_box(1)));
        const View<const Vec3f> positions = view_of(std::as_const(moved));
        for (int i = 0; i < 400; ++i) {
            const auto t = static_cast<std::uint32_t>(
                random.integer(0, static_cast<int>(mesh.triangles.size) - 1));
            double w[3] = {random.uniform(0.01, 1), random.uniform(0.01, 1),
                           random.uniform(0.01, 1)};
            const double sum = w[0] + w[1] + w[2];
            Vec3d at, corner[3];
            for (int k = 0; k < 3; ++k) {
                corner[k] = corner_of(mesh, positions, t, k);
                at += (w[k] / sum) * corner[k];
            }
            Ray ray;
            ray.direction = normalized(
                normalized(cross(corner[1] - corner[0], corner[2] - corner[0])) +
                random.in_box(0.7));
            const double depth = random.uniform(-0.1, 0.3) * random.uniform(0, 1);
            ray.origin = at - depth * ray.direction;
            ray.t_max = 9;
            const Crossing crossing = cross_triangle({ray.origin, ray.direction}, corner[0],
                                                     corner[1], corner[2]);
            ++tried;
            if (!is_only_crossing(mesh.rings[t], crossing, ray.direction, deviation, touch))
                continue;
            const Hit hit = traced(mesh, positions, ray);
            if (crossing.t >= -touch) {
                ++proved;
                ASSERT_EQ(hit.triangle, t) << "mesh " << m << " ray " << i;
            } else {
                ++behind;
                Ray back = ray;
                back.direction = -ray.direction;
                ASSERT_EQ(traced(mesh, positions, back).triangle, t)
                    << "mesh " << m << " ray " << i;
                double distance = 9;
                for (std::uint32_t other = 0; other < mesh.triangles.size; ++other)
                    distance = std::min(
                        distance,
                        length(ray.origin -
                               closest_on_triangle(ray.origin, corner_of(mesh, positions, other, 0),
                                                   corner_of(mesh, positions, other, 1),
                                                   corner_of(mesh, positions, other, 2))));
                const double height = std::fabs(crossing.t) *
                                      std::fabs(dot(normalized(cross(corner[1] - corner[0],
                                                                     corner[2] - corner[0])),
                                                    ray.direction));
                const double proved_distance = distance_in_front(mesh.rings[t], crossing, height) -
                                               2 * (touch + deviation);
                ASSERT_LE(proved_distance, distance) << "mesh " << m << " ray " << i;
                in_front += proved_distance > 0;
                if (mesh.simple && deviation == 0 && hit.triangle != no_triangle) {
                    ASSERT_FALSE(leads_out(ray, {positions, mesh.triangles, touch}, hit.triangle))
                        << "it starts outside";
                }
            }
        }
    }
    EXPECT_GT(proved, tried / 10);
    EXPECT_GT(behind, tried / 50);
    EXPECT_GT(in_front, behind / 20);
}

/// Looking both ways at once, against a ray each way.
TEST(PredictionTest, OneTraversalFindsWhatTwoRaysFind) {
    test::Random random(14);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int ahead = 0, predicted = 0, kept = 0;
    for (int m = 0; m < 60; ++m) {
        const Mesh shape("any", test::random_closed_mesh(random));
        const MeshView mesh = shape.view();
        const Surface surface{mesh.positions, mesh.triangles,
                              constants::touch_tolerance * mesh.box.extent()};
        for (int i = 0; i < 300; ++i) {
            Ray ray;
            ray.origin = random.in_box(1.2);
            ray.direction = random.unit_vector();
            ray.t_max = random.uniform(0, 2);
            Ray back = ray;
            back.direction = -ray.direction;
            back.t_max = random.uniform(0, 1);
            Hit expected = traced(mesh, mesh.positions, ray);
            if (expected.triangle == no_triangle || !leads_out(ray, surface, expected.triangle)) {
                const Hit entry = traced(mesh, mesh.positions, back);
                if (entry.triangle != no_triangle && !leads_out(back, surface, entry.triangle))
                    expected = {entry.triangle, true};
            }
            ray.outward = back.t_max;
            const Hit hit = traced(mesh, mesh.positions, ray);
            ASSERT_EQ(hit, expected) << "mesh " << m << " ray " << i;
            ahead += hit.triangle != no_triangle && !hit.predicted &&
                     leads_out(ray, surface, hit.triangle);
            kept += hit.triangle != no_triangle && !hit.predicted &&
                    !leads_out(ray, surface, hit.triangle);
            predicted += hit.predicted;
        }
    }
    EXPECT_GT(ahead, 2000);
    EXPECT_GT(predicted, 500);
    EXPECT_GT(kept, 200);
}

TEST(MeshTest, SimpleMeshesDoNotMeetThemselves) {
    EXPECT_TRUE(Mesh("torus", scenes::torus(2, 0.5, 30, 10)).view().simple);
    EXPECT_TRUE(Mesh("box", scenes::box({0, 0, 0}, {1, 1, 1})).view().simple);
    EXPECT_FALSE(Mesh("crossing itself", scenes::torus(0.4, 0.5, 30, 10)).view().simple);
    MeshData two = scenes::box({0, 0, 0}, {1, 1, 1});
    const MeshData inner = scenes::box({0.2, 0.2, 0.2}, {0.8, 0.8, 0.8});
    for (Triangle t : inner.triangles)
        two.triangles.push_back({{t.vertex[0] + 8, t.vertex[1] + 8, t.vertex[2] + 8}});
    two.positions.insert(two.positions.end(), inner.positions.begin(), inner.positions.end());
    EXPECT_FALSE(Mesh("one in another", two).view().simple);
    MeshData inside_out = scenes::box({0, 0, 0}, {1, 1, 1});
    for (Triangle& t : inside_out.triangles) std::swap(t.vertex[0], t.vertex[1]);
    EXPECT_FALSE(Mesh("inside out", inside_out).view().simple);
}

TEST(MotionBoundTest, NoPointOfTheBoxMovesFurther) {
    test::Random random(13);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    double tightest = 9;
    for (int i = 0; i < 500; ++i) {
        Box box;
        for (int k = 0; k < 2; ++k) box.extend(random.in_box(2));
        const double angle = random.uniform(0, i % 2 == 0 ? 0.01 : 3);
        const Vec3d axis = std::sin(angle / 2) * random.unit_vector();
        const Frame from = frame_of({random.in_box(3), random.rotation()});
        const Frame turn = frame_of(
            {random.in_box(0.02), {axis.x, axis.y, axis.z, std::cos(angle / 2)}});
        const Frame to{turn.rotation * from.rotation, turn.to_parent(from.origin)};
        const double bound = largest_motion(from, to, box);
        for (int n = 0; n < 20; ++n) {
            Vec3d p;
            for (int k = 0; k < 3; ++k)
                p[k] = n < 8 ? (n >> k & 1 ? box.upper[k] : box.lower[k])
                             : random.uniform(box.lower[k], box.upper[k]);
            const double motion = length(to.to_parent(p) - from.to_parent(p));
            ASSERT_LE(motion, bound * (1 + 1e-12));
            tightest = std::min(tightest, bound / motion);
        }
    }
    EXPECT_LT(tightest, 1.1);
}

TEST(ClosestPointTest, AgreesWithSampling) {
    test::Random random(14);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int i = 0; i < 300; ++i) {
        const Vec3d a = random.in_box(1), b = random.in_box(1), c = random.in_box(1),
                    d = random.in_box(1), p = random.in_box(2);
        const double found = length(p - closest_on_triangle(p, a, b, c));
        const double apart = segment_distance(a, b, c, d);
        double sampled = 9, segments = 9;
        constexpr int n = 60;
        for (int u = 0; u <= n; ++u)
            for (int v = 0; v <= n; ++v) {
                if (u + v <= n)
                    sampled = std::min(sampled,
                                       length(p - (1.0 / n) * (u * a + v * b + (n - u - v) * c)));
                segments = std::min(segments, length((1.0 / n) * (u * a + (n - u) * b) -
                                                     (1.0 / n) * (v * c + (n - v) * d)));
            }
        ASSERT_LE(found, sampled + 1e-12);
        ASSERT_NEAR(found, sampled, 0.05);
        ASSERT_LE(apart, segments + 1e-12);
        ASSERT_NEAR(apart, segments, 0.05);
    }
}

}  // namespace
}  // namespace pierce
