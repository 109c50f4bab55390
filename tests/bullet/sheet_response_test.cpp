// Sheets moved by anything at all stay on their sides: the promise of SheetResponse, without a
// simulation around it.
#include "pierce/bullet/sheet_response.hpp"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
#include "scenes/detect/soft_sheet.hpp"
#include "scenes/named/shapes.hpp"
#include "scenes/simulate/sheet_crossings.hpp"
#include "support/random.hpp"

namespace pierce::bullet {
namespace {

constexpr double dt = 0.01;

/// Sheets and a ball that does not move; Bullet's part is played by whoever writes the nodes.
class SheetResponseTest : public testing::Test {
protected:
    void make(std::uint32_t sheets, SheetSettings settings) {
        mesh = scenes::grid(1, 1, nodes, nodes);
        response = std::make_unique<SheetResponse>(world, settings);
        const MeshId id = world.add_mesh("sheet", mesh);
        for (std::uint32_t s = 0; s < sheets; ++s) {
            scenes::SceneBody body;
            body.motion = Motion::deforming;
            body.pose.position.z = height + gap * s;
            soft.push_back(std::make_unique<scenes::SoftSheet>(info, body, mesh));
            bodies.push_back(world.add_deforming_body(id, positions(s)));
            world.set_collision(bodies.back(), {SelfCollision::on, true, thickness});
            response->bind(soft.back()->soft(), bodies.back());
        }
        ball_mesh = scenes::sphere(ball_radius, 2);
        world.add_fixed_body(world.add_mesh("ball", ball_mesh));
    }

    std::vector<Vec3f> positions(std::uint32_t sheet) const {
        std::vector<Vec3f> list;
        const auto& all = soft[sheet]->soft().m_nodes;
        for (int i = 0; i < all.size(); ++i) list.push_back(from_bullet_float(all[i].m_x));
        return list;
    }

    /// What a solver that knows of no contact may do: `move` gives every node's way.
    template <class Move>
    const SheetReport& step(const Move& move) {
        for (std::uint32_t s = 0; s < soft.size(); ++s) {
            auto& all = soft[s]->soft().m_nodes;
            for (int i = 0; i < all.size(); ++i) {
                all[i].m_q = all[i].m_x;
                all[i].m_x += to_bullet(move(s, static_cast<std::uint32_t>(i)));
            }
        }
        return response->finish_step(dt);
    }

    /// Edges through triangles, among all surfaces.
    std::uint32_t crossing_count() const {
        std::uint32_t count = 0;
        for (std::uint32_t a = 0; a < soft.size(); ++a) {
            count += scenes::self_crossings(mesh.triangles, positions(a)).count;
            count += scenes::crossings(mesh.triangles, positions(a), ball_mesh.triangles,
                                       ball_mesh.positions)
                         .count;
            for (std::uint32_t b = a + 1; b < soft.size(); ++b)
                count += scenes::crossings(mesh.triangles, positions(a), mesh.triangles,
                                           positions(b))
                             .count;
        }
        return count;
    }

    static constexpr std::uint32_t nodes = 9;
    static constexpr double thickness = 0.02, gap = 0.05, ball_radius = 0.3, height = 0.35;
    btSoftBodyWorldInfo info;
    World world{embree_backend(1)};
    MeshData mesh, ball_mesh;
    std::vector<std::unique_ptr<scenes::SoftSheet>> soft;
    std::vector<BodyId> bodies;
    std::unique_ptr<SheetResponse> response;
};

TEST_F(SheetResponseTest, WhatCannotBeIsRefused) {
    make(1, {});
    const std::vector<Vec3f> before = positions(0);
    for (const double time : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
        EXPECT_THROW(response->finish_step(time), InputError);
    EXPECT_EQ(positions(0), before);
    btSphereShape shape(1);
    btRigidBody rigid(1, nullptr, &shape);
    EXPECT_THROW(response->bind(rigid, BodyId{}), InputError);
    EXPECT_THROW(response->bind(rigid, bodies[0]), InputError);
}

TEST_F(SheetResponseTest, WildMotionCrossesNothing) {
    make(3, {});
    test::Random random(11);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    for (int i = 0; i < 30; ++i) {
        step([&](std::uint32_t s, std::uint32_t) {
            return Vec3d{0, 0, s == 0 ? 0.05 : -0.05} + 0.05 * random.unit_vector();
        });
        ASSERT_EQ(crossing_count(), 0u) << "step " << i;
        EXPECT_EQ(response->report().crossings_left, 0u);
    }
}

TEST_F(SheetResponseTest, PullingBackAloneIsEnoughAndIsReported) {
    make(2, {.projection = {}, .rounds = 0});
    test::Random random(11);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::uint32_t pulled_back = 0;
    for (int i = 0; i < 20; ++i) {
        pulled_back += step([&](std::uint32_t s, std::uint32_t) {
                           return Vec3d{0, 0, s == 0 ? 0.1 : -0.1} + 0.03 * random.unit_vector();
                       }).pulled_back;
        ASSERT_EQ(crossing_count(), 0u) << "step " << i;
    }
    EXPECT_GT(pulled_back, 0u);
}

TEST_F(SheetResponseTest, SheetsThatMeetKeepTheirMomentumAndAGap) {
    make(2, {});
    // Above the ball, towards each other, the upper one twice as fast.
    const SheetReport& report = step([](std::uint32_t s, std::uint32_t) {
        return Vec3d{0, 0, s == 0 ? 0.04 : -0.08};
    });
    EXPECT_GT(report.crossings, 0u);
    EXPECT_EQ(report.pulled_back, 0u);
    double momentum = 0, mass = 0, lowest = 1;
    for (const auto& sheet : soft)
        for (int i = 0; i < sheet->soft().m_nodes.size(); ++i) {
            const btSoftBody::Node& node = sheet->soft().m_nodes[i];
            momentum += node.m_v.z() / node.m_im;
            mass += 1 / node.m_im;
        }
    const double kept = 1 - soft[0]->soft().m_cfg.kDP;
    EXPECT_NEAR(momentum / mass, kept * -0.02 / dt, 1e-3);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        lowest = std::min(lowest, static_cast<double>(positions(1)[i].z - positions(0)[i].z));
    EXPECT_GT(lowest, 0.75 * thickness);
}

/// A plate that is told where to go and moves through where a sheet is.
TEST_F(SheetResponseTest, APlateThatIsLedIntoASheetPushesItAndIsNotPassed) {
    make(1, {});
    const MeshData plate = scenes::box({-1, -1, -0.05}, {1, 1, 0.05});
    const Vec3d above{0, 0, 0.6};
    const BodyId id = world.add_fixed_body(world.add_mesh("plate", plate), {above, {}});
    btBoxShape shape({1, 1, btScalar(0.05)});
    btRigidBody rigid(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &shape, {}));
    const auto place = [&](double down) {
        rigid.setWorldTransform(to_bullet(Pose{above - Vec3d{0, 0, down}, {}}));
        std::vector<Vec3f> at;
        for (Vec3f p : plate.positions)
            at.push_back(to_float(to_double(p) + above - Vec3d{0, 0, down}));
        return at;
    };
    place(0);
    response->bind(rigid, id);
    // Over the ball, the sheet has 0.05 to give way; then it hangs down beside it.
    std::uint32_t met = 0;
    double lowest = height;
    for (int i = 1; i <= 24; ++i) {
        const std::vector<Vec3f> at = place(0.01 * i);
        met += step([](std::uint32_t, std::uint32_t) { return Vec3d{}; }).contacts;
        ASSERT_EQ(response->report().crossings_left, 0u) << "step " << i;
        ASSERT_EQ(scenes::crossings(mesh.triangles, positions(0), plate.triangles, at).count, 0u)
            << "step " << i;
        ASSERT_EQ(crossing_count(), 0u) << "step " << i;
        for (Vec3f p : positions(0)) {
            ASSERT_LT(p.z, at[0].z) << "a vertex is above the plate's lower side, step " << i;
            lowest = std::min(lowest, static_cast<double>(p.z));
        }
    }
    EXPECT_GT(met, 0u);
    EXPECT_LT(lowest, height - 0.01) << "it was pushed";
}

/// Leaves it no room: that is counted, and the step ends.
TEST_F(SheetResponseTest, AnObstacleThatLeavesNoRoomIsReported) {
    make(1, {});
    for (int i = 0; i < soft[0]->soft().m_nodes.size(); ++i) soft[0]->soft().setMass(i, 0);
    const MeshData plate = scenes::box({-1, -1, -0.05}, {1, 1, 0.05});
    btBoxShape shape({1, 1, btScalar(0.05)});
    btRigidBody rigid(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &shape, {}));
    const Pose start{{0, 0, 0.6}, {}};
    const BodyId id = world.add_fixed_body(world.add_mesh("plate", plate), start);
    rigid.setWorldTransform(to_bullet(start));
    response->bind(rigid, id);
    std::uint32_t left = 0;
    for (int i = 1; i <= 5; ++i) {
        rigid.setWorldTransform(to_bullet(Pose{{0, 0, 0.6 - 0.1 * i}, {}}));
        left += step([](std::uint32_t, std::uint32_t) { return Vec3d{}; }).crossings_left;
    }
    EXPECT_GT(left, 0u);
}

/// A heavy box falls on a sheet that lies on a floor.
TEST_F(SheetResponseTest, AHeavyFreeBodyIsHeldWhereTheSheetCannotGoBack) {
    make(1, {});
    constexpr double floor = height - 0.03, half = 0.05, speed = 20;
    const MeshData block = scenes::box({-0.3, -0.2, -half}, {0.3, 0.2, half});
    world.add_fixed_body(world.add_mesh("floor", scenes::box({-2, -2, -1}, {2, 2, 0})),
                         {{0, 0, floor}, {}});
    btBoxShape shape({btScalar(0.3), btScalar(0.2), btScalar(half)});
    btVector3 inertia;
    shape.calculateLocalInertia(1e4, inertia);
    btRigidBody rigid(btRigidBody::btRigidBodyConstructionInfo(1e4, nullptr, &shape, inertia));
    Pose at{{0, 0, height + 0.3}, {}};
    const BodyId id = world.add_rigid_body(world.add_mesh("block", block), at);
    rigid.setWorldTransform(to_bullet(at));
    rigid.updateInertiaTensor();
    response->bind(rigid, id);
    std::uint32_t held = 0;
    for (int i = 0; i < 8; ++i) {
        rigid.setWorldTransform(to_bullet({at.position - Vec3d{0, 0, speed * dt}, at.rotation}));
        rigid.setLinearVelocity({0, 0, btScalar(-speed)});
        const SheetReport& report = step([](std::uint32_t, std::uint32_t) { return Vec3d{}; });
        held += report.held_bodies;
        EXPECT_EQ(report.crossings_left, 0u);
        if (report.held_bodies > 0) {
            EXPECT_EQ(from_bullet(rigid.getLinearVelocity()), Vec3d{});
            EXPECT_EQ(from_bullet(rigid.getInterpolationLinearVelocity()), Vec3d{});
        }
        at = from_bullet(rigid.getWorldTransform());
        EXPECT_EQ(scenes::crossings(mesh.triangles, positions(0), block.triangles,
                                    test::placed(block, at))
                      .count,
                  0u);
        EXPECT_GT(at.position.z - half, floor) << "step " << i;
    }
    EXPECT_GT(held, 0u);
}

/// What Bullet does not simulate cannot be pulled back, and holds nobody.
TEST_F(SheetResponseTest, ASheetThatIsNotBoundHoldsNobody) {
    make(1, {});
    const BodyId unbound = world.add_deforming_body(world.add_mesh("unbound", mesh));
    world.set_collision(unbound, {SelfCollision::off, true, thickness});
    const Pose start{{5, 0, 0.5}, {}}, end{{5, 0, -0.5}, {}};
    world.set_positions(unbound, test::placed(mesh, {{5, 0, 0}, {}}));
    btBoxShape shape({btScalar(0.1), btScalar(0.1), btScalar(0.1)});
    btRigidBody rigid(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, {1, 1, 1}));
    rigid.setWorldTransform(to_bullet(start));
    response->bind(
        rigid, world.add_rigid_body(
                   world.add_mesh("box", scenes::box({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1})), start));
    rigid.setWorldTransform(to_bullet(end));
    const SheetReport& report = step([](std::uint32_t, std::uint32_t) { return Vec3d{}; });
    EXPECT_EQ(report.held_bodies, 0u);
    EXPECT_NEAR(from_bullet(rigid.getWorldTransform()).position.z, -0.5, 1e-6);
}

/// A sheet that is thrown at a box beside its centre.
struct ThrownSheet {
    btBoxShape shape{btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.1))};
    std::unique_ptr<btRigidBody> rigid;

    explicit ThrownSheet(double mass) {
        btVector3 inertia(0, 0, 0);
        if (mass > 0) shape.calculateLocalInertia(static_cast<btScalar>(mass), inertia);
        rigid = std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(
            static_cast<btScalar>(mass), nullptr, &shape, inertia));
        rigid->setWorldTransform(to_bullet(start));
        rigid->updateInertiaTensor();
    }

    static constexpr Pose start{{0.35, 0.1, 0.55}, {}};
};

TEST_F(SheetResponseTest, AFreeBodyTakesTheMomentumThatTheSheetLoses) {
    for (double mass : {0.1, 1.0, 20.0}) {
        soft.clear();
        bodies.clear();
        make(1, {});
        ThrownSheet thrown(mass);
        const BodyId box = world.add_rigid_body(
            world.add_mesh("box", scenes::box({-0.3, -0.3, -0.1}, {0.3, 0.3, 0.1})),
            ThrownSheet::start);
        response->bind(*thrown.rigid, box);
        soft[0]->soft().m_cfg.kDP = 0;
        const double speed = 0.12 / dt;
        const SheetReport& report = step([](std::uint32_t, std::uint32_t) {
            return Vec3d{0, 0, 0.12};
        });
        EXPECT_GT(report.crossings, 0u);
        EXPECT_EQ(report.pulled_back, 0u);
        EXPECT_EQ(report.moved_bodies, 1u);
        EXPECT_EQ(report.crossings_left, 0u);
        const btRigidBody& rigid = *thrown.rigid;
        Vec3d momentum, spin, spin_before;
        double nodes_mass = 0;
        const btAlignedObjectArray<btSoftBody::Node>& all = soft[0]->soft().m_nodes;
        for (int i = 0; i < all.size(); ++i) {
            const double m = 1 / static_cast<double>(all[i].m_im);
            const Vec3d v = from_bullet(all[i].m_v), begin = from_bullet(all[i].m_q),
                        end = from_bullet(all[i].m_x);
            nodes_mass += m;
            momentum += m * v;
            spin += m * cross(end, v);
            spin_before += m * cross(begin, Vec3d{0, 0, speed});
        }
        const Vec3d taken = mass * from_bullet(rigid.getLinearVelocity());
        EXPECT_GT(taken.z, 0.01 * nodes_mass * speed) << "it was hit";
        EXPECT_LT(length(momentum + taken - Vec3d{0, 0, nodes_mass * speed}),
                  1e-4 * nodes_mass * speed)
            << "mass " << mass;
        const btMatrix3x3 inertia = rigid.getInvInertiaTensorWorld().inverse();
        const Vec3d spin_taken = cross(ThrownSheet::start.position, taken) +
                                 from_bullet(inertia * rigid.getAngularVelocity());
        // A push acts on the sheet and on the box a thickness apart, and both go on during the
        // step.
        EXPECT_LT(length(spin + spin_taken - spin_before),
                  0.05 * length(cross(ThrownSheet::start.position, taken)))
            << "mass " << mass;
        EXPECT_GT(from_bullet(rigid.getLinearVelocity()).z, 0);
        world.remove_body(box);
        world.remove_body(bodies[0]);
    }
}

TEST_F(SheetResponseTest, ASleepingBodyIsWokenByAStrongPushOnly) {
    make(1, {});
    ThrownSheet thrown(1);
    const BodyId box = world.add_rigid_body(
        world.add_mesh("box", scenes::box({-0.3, -0.3, -0.1}, {0.3, 0.3, 0.1})),
        ThrownSheet::start);
    response->bind(*thrown.rigid, box);
    thrown.rigid->setActivationState(ISLAND_SLEEPING);
    const auto touches = [&] {
        return std::ranges::any_of(world.contacts(),
                                   [&](const Contact& c) { return c.b == box && c.of_sheet; });
    };
    // Slowly, until it lies against the box.
    for (int i = 0; i < 16; ++i) {
        EXPECT_EQ(step([](std::uint32_t, std::uint32_t) {
                      return Vec3d{0, 0, 0.006};
                  }).moved_bodies,
                  0u);
        EXPECT_FALSE(thrown.rigid->isActive());
    }
    EXPECT_TRUE(touches());
    step([](std::uint32_t, std::uint32_t) { return Vec3d{0, 0, 0.1}; });
    EXPECT_TRUE(thrown.rigid->isActive());
    EXPECT_EQ(thrown.rigid->getWorldTransform().getOrigin().distance(
                  to_bullet(ThrownSheet::start.position)),
              0)
        << "not in that step";
    EXPECT_EQ(crossing_count(), 0u);
    EXPECT_EQ(step([](std::uint32_t, std::uint32_t) {
                  return Vec3d{0, 0, 0.05};
              }).moved_bodies,
              1u);
}

TEST_F(SheetResponseTest, SheetsThatStartTangledEndEveryStepAndAreReported) {
    make(2, {});
    // The upper sheet's middle column hangs through the lower one.
    auto& upper = soft[1]->soft().m_nodes;
    for (int i = 0; i < upper.size(); ++i)
        upper[i].m_x += btVector3(btScalar(0.03), btScalar(0.04), 0);
    for (std::uint32_t j = 0; j < nodes; ++j)
        upper[static_cast<int>(j * nodes + nodes / 2)].m_x.setZ(
            static_cast<btScalar>(height - gap));
    response = std::make_unique<SheetResponse>(world, SheetSettings{});
    for (std::uint32_t s = 0; s < 2; ++s) response->bind(soft[s]->soft(), bodies[s]);
    ASSERT_GT(crossing_count(), 0u);
    test::Random random(11);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::uint32_t tangled = 0;
    for (int i = 0; i < 10; ++i) {
        const SheetReport& report = step([&](std::uint32_t s, std::uint32_t) {
            return Vec3d{0, 0, s == 0 ? 0.02 : -0.02} + 0.02 * random.unit_vector();
        });
        tangled += report.tangled;
        EXPECT_LT(report.detections, 64u) << "step " << i;
        for (std::uint32_t s = 0; s < 2; ++s)
            for (Vec3f p : positions(s)) ASSERT_TRUE(is_finite(p)) << "step " << i;
    }
    EXPECT_GT(tangled, 0u);
}

}  // namespace
}  // namespace pierce::bullet
