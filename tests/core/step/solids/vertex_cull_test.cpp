// What balls near a target promise about later steps.
#include "core/step/solids/vertex_cull.hpp"

#include <gtest/gtest.h>

#include "core/body/body_view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/trace/closest_search.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

/// A body of a mesh as a step would see it, in its rest shape.
BodyView body_of(const Mesh& mesh, Motion motion) {
    BodyView body;
    body.mesh = mesh.view();
    body.positions = body.mesh.positions;
    body.blocks = body.mesh.blocks;
    body.patches = body.mesh.patches;
    body.fit_box = body.mesh.box;
    body.touch = constants::touch_tolerance * body.mesh.box.extent();
    body.motion = motion;
    return body;
}

Offsets random_offsets(test::Random& random, double size) {
    Offsets offsets;
    for (std::uint32_t k = 0; k < Offsets::count; ++k)
        offsets.set(k, to_float(random.in_box(size)));
    return offsets;
}

TEST(BallsNearbyTest, AGapHoldsWhileTheBallMovesByLess) {
    test::Random random(41);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    int held = 0;
    for (int m = 0; m < 60; ++m) {
        const Mesh mesh("any", test::random_closed_mesh(random));
        // A deforming target proves nothing but what its grid says: it must say so again.
        const BodyView target = body_of(mesh, Motion::deforming);
        for (int i = 0; i < 300; ++i) {
            const Offsets offsets = random_offsets(random, 0.2);
            const Vec3d center = random.in_box(1.3);
            const stages::BallsNearby<> before(target, {}, center, offsets, nullptr, 0.4, 0);
            for (std::uint32_t k = 0; k < Offsets::count; ++k) {
                if (!(before.gap(k) > 0)) continue;
                const Vec3d way = random.uniform(0, 0.999) * static_cast<double>(before.gap(k)) *
                                  random.unit_vector();
                const stages::BallsNearby<> after(target, {}, center + way, offsets, nullptr, 0.4,
                                                  0);
                ++held;
                ASSERT_FALSE(after.near >> k & 1u) << "mesh " << m << " try " << i << " ball " << k;
            }
        }
    }
    EXPECT_GT(held, 10000);
}

TEST(BallsNearbyTest, WhatIsNotNearIsOutside) {
    test::Random random(42);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int m = 0; m < 30; ++m) {
        const Mesh mesh("any", test::random_closed_mesh(random));
        const BodyView target = body_of(mesh, Motion::rigid);
        for (int i = 0; i < 100; ++i) {
            const Offsets offsets = random_offsets(random, 0.2);
            const Vec3d center = random.in_box(1.3);
            const stages::BallsNearby<> balls(target, {}, center, offsets, nullptr, 0.4, 0);
            for (std::uint32_t k = 0; k < Offsets::count; ++k) {
                const Vec3d p = center + Vec3d{offsets.x[k], offsets.y[k], offsets.z[k]};
                double nearest = 9;
                for (std::uint32_t t = 0; t < target.mesh.triangles.size; ++t)
                    nearest = std::min(nearest, distance_to(p, target.surface(), t));
                if (!(balls.near >> k & 1u)) {
                    ASSERT_GT(nearest, 0);
                }
                ASSERT_LE(balls.gap(k), nearest) << "a gap is a distance that is there";
            }
        }
    }
}

Frame random_frame(test::Random& random) { return frame_of({random.in_box(1), random.rotation()}); }

/// A frame a little further on.
Frame moved(test::Random& random, const Frame& frame, double size) {
    const Vec3d turn = random.in_box(size);
    const Matrix3 more = rotation_matrix({turn.x, turn.y, turn.z, 1});
    return {more * frame.rotation, frame.origin + random.in_box(size)};
}

TEST(ApproachTest, ReachesAsFarAsPointsGo) {
    test::Random random(43);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const double steps = 8;
    double tightest = 9;
    for (int i = 0; i < 2000; ++i) {
        BodyView bodies[2];
        for (BodyView& body : bodies) {
            body.motion = random.integer(0, 1) == 0 ? Motion::rigid : Motion::deforming;
            body.last_fit = random_frame(random);
            body.fit = moved(random, body.last_fit, 0.01);
            body.space = body.motion == Motion::rigid ? body.fit : Frame{};
            body.prediction_range = 10;
        }
        const BodyView &source = bodies[0], &target = bodies[1];
        const stages::Approach approach = stages::approach_of(
            source, target, relative_frame(source.fit, target.fit), steps);
        const Vec3d center = random.in_box(1);  // in the source's fit, as is the point
        const double radius = random.uniform(0, 0.3);
        const Vec3d point = center + random.uniform(0, 1) * radius * random.unit_vector();
        const auto in_space = [&](Vec3d p) {
            return source.space.to_local(source.fit.to_parent(p));
        };
        const auto in_target = [&](const Frame& from, const Frame& to) {
            return relative_frame(from, to).to_parent(point);
        };
        const double way = steps * length(in_target(source.fit, target.fit) -
                                          in_target(source.last_fit, target.last_fit));
        ASSERT_NEAR(approach.reach(in_space(point), 0), way, 1e-12);
        const double reach = approach.reach(in_space(center), radius);
        ASSERT_GE(reach, way - 1e-12) << "no point of a ball goes further than the ball's reach";
        tightest = std::min(reach - way, tightest);
        const double change = random.uniform(0, 0.1);
        ASSERT_NEAR(approach.reach(in_space(center), radius, change) - reach,
                    source.motion == Motion::deforming ? steps * change : 0.0, 1e-12)
            << "a change of the source's shape goes on as long";
    }
    EXPECT_LT(tightest, 1e-3);
}

TEST(ApproachTest, UnknownMotionReachesAsFarAsAllowed) {
    stages::Approach approach;
    EXPECT_EQ(approach.reach({1, 2, 3}, 1), 0);
    approach.most = 0.5;
    EXPECT_EQ(approach.reach({1, 2, 3}, 1), 0.5);
}

}  // namespace
}  // namespace pierce
