// Probes against the definition: every crossing of the probe's line, and the winding number.
#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/triangle.hpp"
#include "core/mesh_build/winding_tree.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/world.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

struct Placed {
    MeshData mesh;
    Pose pose;
};

/// How far the body is pressed in, or away; nothing if it is neither, or if the answer hangs on
/// rounding.
struct Expected {
    bool clear = true;
    std::optional<double> distance;
};

Expected expect_of(const Placed& body, Vec3d point, Vec3d normal, double radius) {
    const Frame to_world = frame_of(body.pose);
    const Frame to_local = relative_frame({}, to_world);
    const Vec3d p = to_local.to_parent(point), n = to_local.rotation * normal;
    const double around = WindingTree(body.mesh.positions, body.mesh.triangles).exactly_at(p);
    Expected expected;
    expected.clear = std::fabs(around - std::round(around)) < 1e-3;
    const bool inside = around > 0.5;
    const Vec3d direction = inside ? -n : n;
    for (const Triangle& t : body.mesh.triangles) {
        const Crossing crossing = cross_triangle({p, direction},
                                                 to_double(body.mesh.positions[t.vertex[0]]),
                                                 to_double(body.mesh.positions[t.vertex[1]]),
                                                 to_double(body.mesh.positions[t.vertex[2]]));
        if (crossing.kind == Crossing::none) continue;
        expected.clear = expected.clear && std::fabs(crossing.t) > 1e-4 &&
                         std::fabs(crossing.t - radius) > 1e-4;
        for (const double w : crossing.weight) expected.clear = expected.clear && w > 1e-4;
        if (crossing.t < 0 || (!inside && crossing.t > radius)) continue;
        const double distance = inside ? -crossing.t : crossing.t;
        if (!expected.distance || std::fabs(distance) < std::fabs(*expected.distance))
            expected.distance = distance;
    }
    return expected;
}

TEST(ProbeTest, FindsWhatTheDefinitionSays) {
    test::Random random(9);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t pressed = 0, near = 0, none = 0;
    for (int round = 0; round < 30; ++round) {
        std::vector<Placed> bodies;
        World world(round % 2 == 0 ? reference_backend() : bvh_backend());
        std::vector<BodyId> ids;
        for (int b = 0; b < 3; ++b) {
            bodies.push_back(
                {b == 0 ? scenes::torus(1, 0.3, 14, 8) : test::random_closed_mesh(random),
                 {random.in_box(0.6), random.rotation()}});
            ids.push_back(world.add_rigid_body(world.add_mesh("shape", bodies.back().mesh),
                                               bodies.back().pose));
        }
        world.detect();
        std::vector<Vec3d> points, normals;
        for (int i = 0; i < 40; ++i) {
            points.push_back(random.in_box(1.2));
            normals.push_back(random.uniform(0.5, 2) * random.unit_vector());
        }
        const double radius = 0.3;
        const auto found = world.probe(points, normals, radius);
        const auto of_first = world.probe(points, normals, radius, std::span(ids).first(1));
        for (std::size_t i = 0; i < points.size(); ++i) {
            std::optional<double> least;
            bool clear = true;
            for (std::size_t b = 0; b < bodies.size(); ++b) {
                const Expected one = expect_of(bodies[b], points[i], normalized(normals[i]),
                                               radius);
                clear = clear && one.clear;
                if (one.distance && (!least || *one.distance < *least)) least = one.distance;
                if (b > 0 || !clear) continue;
                ASSERT_EQ(of_first[i].has_value(), one.distance.has_value());
                if (one.distance) {
                    EXPECT_NEAR(of_first[i]->distance, *one.distance, 1e-5);
                }
            }
            if (!clear) continue;
            ASSERT_EQ(found[i].has_value(), least.has_value()) << i;
            if (!least) {
                ++none;
                continue;
            }
            ++(*least < 0 ? pressed : near);
            EXPECT_NEAR(found[i]->distance, *least, 1e-5);
            EXPECT_LT(dot(found[i]->normal, normals[i]), 1e-6) << "it faces the sensor";
        }
    }
    EXPECT_GT(pressed, 150u);
    EXPECT_GT(near, 50u);
    EXPECT_GT(none, 150u);
}

/// Two boxes of one mesh that overlap are one solid, also for probes.
TEST(ProbeTest, PartsThatOverlapAreOne) {
    const MeshData both = scenes::joined(scenes::box({0, 0, 0}, {1, 1, 1}),
                                         scenes::box({0.2, 0.2, 0.5}, {0.8, 0.8, 2}));
    World world(bvh_backend());
    world.add_rigid_body(world.add_mesh("both", both));
    world.detect();
    const std::vector<Vec3d> points{{0.5, 0.5, 0.7}, {0.5, 0.5, 2.1}, {0.5, 0.5, -0.1}};
    const std::vector<Vec3d> normals{{0, 0, -1}, {0, 0, -1}, {0, 0, 1}};
    const auto found = world.probe(points, normals, 0.5);
    ASSERT_TRUE(found[0] && found[1] && found[2]);
    EXPECT_NEAR(found[0]->distance, -1.3, 1e-6);
    EXPECT_NEAR(found[1]->distance, 0.1, 1e-6);
    EXPECT_NEAR(found[2]->distance, 0.1, 1e-6);
}

TEST(ProbeTest, RefusesWhatItCannotAnswer) {
    World world;
    const BodyId ball = world.add_rigid_body(world.add_mesh("ball", scenes::sphere(1, 1)));
    const std::vector<Vec3d> points{{0, 0, 0}}, normals{{0, 0, 1}}, none{{0, 0, 0}},
        nan{{NAN, 0, 0}};
    EXPECT_THROW(world.probe(points, normals, 1), InputError) << "before the first step";
    world.detect();
    EXPECT_THROW(world.probe(points, {}, 1), InputError);
    EXPECT_THROW(world.probe(nan, normals, 1), InputError);
    EXPECT_THROW(world.probe(points, normals, -1), InputError);
    EXPECT_THROW(world.probe(points, normals, INFINITY), InputError);
    EXPECT_FALSE(world.probe(points, none, 1)[0]);
    ASSERT_TRUE(world.probe(points, normals, 1)[0]);
    EXPECT_EQ(world.probe(points, normals, 1)[0]->body, ball);
    world.set_pose(ball, {{1, 0, 0}, {0, 0, 0, 1}});
    EXPECT_THROW(world.probe(points, normals, 1), InputError);
}

TEST(ProbeTest, SeesBodiesFromFarAway) {
    test::Random random(10);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    World world(bvh_backend());
    world.add_fixed_body(world.add_mesh("ball", scenes::sphere(1, 2)));
    world.detect();
    for (const double away : {10.0, 1e6, 1e8}) {
        std::vector<Vec3d> points, normals;
        for (int i = 0; i < 50; ++i) {
            const Vec3d direction = normalized(random.in_box(1));
            points.push_back(away * direction);
            normals.push_back(-direction);
        }
        for (const auto& found : world.probe(points, normals, 2 * away)) {
            ASSERT_TRUE(found) << away;
            EXPECT_NEAR(found->distance, away - 1, 0.15) << away;
        }
        for (const auto& found : world.probe(points, normals, away - 1.2)) EXPECT_FALSE(found);
    }
}

}  // namespace
}  // namespace pierce
