// Contacts in Bullet: momentum, manifolds, and bodies that come to rest.
#include <gtest/gtest.h>

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>

#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/bullet/contact_frame.hpp"
#include "pierce/bullet/install.hpp"
#include "pierce/bullet/soft_solver.hpp"
#include "pierce/error.hpp"
#include "pierce/penalty_force.hpp"
#include "pierce/reference_backends.hpp"
#include "scenes/named/shapes.hpp"
#include "scenes/simulate/simulation.hpp"
#include "scenes/simulate/soft_damping.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using namespace scenes;

constexpr double dt = 1.0 / 60;

/// Two random deforming bodies and their contacts.
struct Overlap {
    World world;
    std::vector<MeshData> shape;
    std::vector<BodyId> body;

    explicit Overlap(test::Random& random, const Settings& settings = {})
        : world(reference_backend(), settings) {
        for (int k = 0; k < 2; ++k) {
            shape.push_back(test::random_closed_mesh(random));
            const MeshId mesh = world.add_mesh("shape", shape.back());
            shape.back().positions = test::placed(shape.back(),
                                                  {random.in_box(0.5), random.rotation()});
            body.push_back(world.add_deforming_body(mesh, shape.back().positions));
        }
        world.detect();
    }
};

TEST(PenaltyForceTest, ConservesMomentumToRounding) {
    test::Random random(8);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t contacts = 0, edges = 0;
    for (int i = 0; i < 120; ++i) {
        const Overlap overlap(random, {.coverage = Coverage::complete, .reproject = i % 2 == 0});
        for (const Contact& c : overlap.world.contacts()) {
            ++contacts;
            edges += c.is_edge();
            const int source = static_cast<int>(c.source), target = 1 - source;
            const Triangle& t = overlap.shape[static_cast<std::size_t>(target)]
                                    .triangles[c.triangle];
            const Vec3f* corner[3];
            for (int k = 0; k < 3; ++k)
                corner[k] = &overlap.shape[static_cast<std::size_t>(target)].positions[t.vertex[k]];
            const PenaltyForce force = penalty_force(
                c, {.stiffness = 1000, .damping = 3},
                {{random.in_box(1), random.in_box(1)},
                 {random.in_box(1), random.in_box(1), random.in_box(1)}});
            Vec3d sum, torque, push;
            double size = 0;
            const std::uint32_t vertex[2] = {c.vertex, c.edge_end};
            for (int k = 0; k < (c.is_edge() ? 2 : 1); ++k) {
                const Vec3d at = to_double(
                    overlap.shape[static_cast<std::size_t>(source)].positions[vertex[k]]);
                push += force.on_source[k];
                torque += cross(at, force.on_source[k]);
                size += length(force.on_source[k]);
            }
            sum = push;
            for (int k = 0; k < 3; ++k) {
                sum += force.on_corner[k];
                torque += cross(to_double(*corner[k]), force.on_corner[k]);
                size += length(force.on_corner[k]);
            }
            EXPECT_LE(length(sum), 1e-14 * size);
            EXPECT_LE(length(torque), 1e-13 * size);
            EXPECT_GE(dot(push, force.direction), -1e-9 * size) << "pushes out, never pulls";
        }
    }
    EXPECT_GT(contacts, 500u);
    EXPECT_GT(edges, 500u);
}

TEST(ContactFrameTest, PointsLieOneDepthApartAlongTheNormal) {
    test::Random random(4);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t seen = 0;
    for (int i = 0; i < 10; ++i) {
        const Overlap overlap(random);
        seen += overlap.world.contacts().size();
        for (const Contact& c : overlap.world.contacts()) {
            const bullet::FramedContact f = bullet::face_frame(c);
            const Vec3d apart = f.point_a - f.point_b;
            EXPECT_NEAR(length(apart - f.distance * f.normal_on_b), 0, 1e-9)
                << "Bullet: (A - B) . normal = distance";
            EXPECT_LE(f.distance, 0);
            EXPECT_LE(-f.distance, c.penetration_depth() + 1e-9)
                << "a face's depth is never more than the ray's";
        }
    }
    EXPECT_GT(seen, 100u);
}

TEST(SimulationTest, ATorusComesToRestOnThePlane) {
    const SceneSetup scene = make_scene("tori", {1, false, 4});
    Simulation simulation(scene, Method::rays, {"embree", 1});
    for (int i = 0; i < 600; ++i) simulation.step(dt);
    EXPECT_LT(simulation.kinetic_energy_per_mass(), 1e-3);
    double lowest = 1e9, highest = -1e9;
    for (std::uint32_t v = 0; v < 300; ++v) {
        lowest = std::min(lowest, simulation.vertex_position(1, v).z);
        highest = std::max(highest, simulation.vertex_position(1, v).z);
    }
    EXPECT_NEAR(lowest, 0, 0.02);
    EXPECT_LT(highest, 1.1) << "it lies flat";
}

/// How far bodies may move in the last second; a torus is 5 wide.
struct Drift {
    double median, most;
};

void expect_pile(const SceneSetup& scene, int steps, double lowest_allowed, Drift drift) {
    Simulation simulation(scene, Method::rays);
    const auto centers = [&] {
        std::vector<Vec3d> result;
        for (std::uint32_t b = 1; b < scene.bodies.size(); ++b) {
            Vec3d sum;
            for (std::uint32_t v = 0; v < 300; ++v) sum += simulation.vertex_position(b, v);
            result.push_back(sum * (1.0 / 300));
        }
        return result;
    };
    for (int i = 0; i < steps - 60; ++i) simulation.step(dt);
    const std::vector<Vec3d> before = centers();
    double deepest = 0;
    for (int i = 0; i < 60; ++i) deepest = std::max(deepest, simulation.step(dt).penetration_max);
    const std::vector<Vec3d> after = centers();
    std::vector<double> moved;
    for (std::size_t b = 0; b < before.size(); ++b) moved.push_back(length(after[b] - before[b]));
    std::ranges::sort(moved);
    EXPECT_LT(moved[moved.size() / 2], drift.median);
    EXPECT_LT(moved.back(), drift.most);
    EXPECT_LT(deepest, 0.5) << "a tube is 1 thick";
    EXPECT_LT(simulation.kinetic_energy_per_mass(), 1e-3);
    for (std::uint32_t b = 1; b < scene.bodies.size(); ++b) {
        for (std::uint32_t v = 0; v < 300; ++v)
            ASSERT_GT(simulation.vertex_position(b, v).z, lowest_allowed);
        EXPECT_NEAR(simulation.volume_ratio(b), 1, 0.1);
    }
}

TEST(SimulationTest, AHundredToriStayAboveThePlaneAndComeToRest) {
    expect_pile(make_scene("tori"), 720, -0.1, {0.02, 0.5});
}

// A hundredth and a tenth of a percent of a torus' width.
TEST(SimulationTest, AHundredSoftToriKeepTheirVolumeAndComeToRest) {
    expect_pile(make_scene("tori", {100, true, 1}), 1980, -0.1, {0.0005, 0.005});
}

TEST(SimulationTest, RefusesWhatItCannotDo) {
    const SceneSetup soft = make_scene("tori", {1, true, 1});
    EXPECT_THROW(Simulation(soft, Method::gimpact), InputError);
    EXPECT_THROW(Simulation(make_scene("tori", {1, false, 1}), Method::rays, {"cuda", 1}),
                 InputError);
    Simulation simulation(make_scene("tori", {1, false, 1}), Method::rays, {"embree", 1});
    EXPECT_THROW(simulation.step(0), InputError);
    EXPECT_THROW(simulation.step(-dt), InputError);
}

TEST(SimulationTest, BaselinesHoldToriUpToo) {
    for (Method method : {Method::gjk_epa, Method::gjk_hull, Method::gimpact}) {
        const SceneSetup scene = make_scene("tori", {4, false, 4});
        Simulation simulation(scene, method);
        std::size_t touching = 0;
        for (int i = 0; i < 240; ++i) touching += simulation.step(dt).touching.size();
        EXPECT_GT(touching, 0u);
        for (std::uint32_t b = 1; b < scene.bodies.size(); ++b)
            for (std::uint32_t v = 0; v < 300; ++v)
                EXPECT_GT(simulation.vertex_position(b, v).z, -0.3);
    }
}

TEST(SoftDampingTest, StopsVibrationAndKeepsTheMotionAsAWhole) {
    const MeshData ball = scenes::sphere(1, 2);
    std::vector<btScalar> coordinates;
    std::vector<int> indices;
    for (Vec3f p : ball.positions) coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
    for (const Triangle& t : ball.triangles)
        for (std::uint32_t v : t.vertex) indices.push_back(static_cast<int>(v));
    btSoftBodyWorldInfo info;
    const std::unique_ptr<btSoftBody> soft(btSoftBodyHelpers::CreateFromTriMesh(
        info, coordinates.data(), indices.data(), static_cast<int>(ball.triangles.size()), false));
    soft->setTotalMass(2);
    test::Random random(4);
    for (int i = 0; i < soft->m_nodes.size(); ++i) {
        const Vec3d noise = random.in_box(1);
        const btVector3 x = soft->m_nodes[i].m_x;
        soft->m_nodes[i].m_v = btVector3(3, 0, 1) + btVector3(0, 2, 1).cross(x) +
                               bullet::to_bullet(noise);
    }
    struct Motion {
        Vec3d momentum, spin;
        double energy;
    };
    const auto motion = [&] {
        Motion m{};
        for (int i = 0; i < soft->m_nodes.size(); ++i) {
            const Vec3d x = bullet::from_bullet(soft->m_nodes[i].m_x),
                        v = bullet::from_bullet(soft->m_nodes[i].m_v);
            m.momentum += v;
            m.spin += cross(x, v);
            m.energy += length_squared(v);
        }
        return m;
    };
    const Motion before = motion();
    scenes::damp_vibration(*soft, 1);
    const Motion after = motion();
    EXPECT_NEAR(length(after.momentum - before.momentum), 0, 1e-4 * length(before.momentum));
    EXPECT_NEAR(length(after.spin - before.spin), 0, 1e-4 * length(before.spin));
    EXPECT_LT(after.energy, before.energy - 0.5 * soft->m_nodes.size()) << "the noise is gone";
    scenes::damp_vibration(*soft, 1);
    EXPECT_NEAR(motion().energy, after.energy, 1e-4 * after.energy) << "and nothing else";
}

/// A rigid and a soft body meet in mid-air, without gravity.
TEST(InstallTest, RigidAndSoftBodiesPushEachOther) {
    World world;
    const MeshData ball = scenes::sphere(1, 2);
    const MeshId mesh = world.add_mesh("ball", ball);
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btSoftRigidDynamicsWorld bullet_world(&dispatcher, &broadphase, &solver, &configuration);
    bullet::Installation& installed = bullet::install(bullet_world, world, {.automatic = false});
    bullet_world.setGravity({0, 0, 0});
    bullet_world.getWorldInfo().m_gravity.setZero();

    btSphereShape shape(1);
    btVector3 inertia;
    shape.calculateLocalInertia(1, inertia);
    btRigidBody rigid(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, inertia));
    rigid.setLinearVelocity({2, 0, 0});
    bullet_world.addRigidBody(&rigid);
    std::vector<btScalar> coordinates;
    for (Vec3f p : ball.positions)
        coordinates.insert(coordinates.end(), {p.x + btScalar(2.5), p.y, p.z});
    std::vector<int> indices;
    for (const Triangle& t : ball.triangles)
        for (std::uint32_t v : t.vertex) indices.push_back(static_cast<int>(v));
    std::unique_ptr<btSoftBody> soft(btSoftBodyHelpers::CreateFromTriMesh(
        bullet_world.getWorldInfo(), coordinates.data(), indices.data(),
        static_cast<int>(ball.triangles.size()), false));
    soft->setTotalMass(1);
    soft->m_cfg.kMT = btScalar(0.3);
    soft->setPose(false, true);
    soft->m_cfg.collisions = 0;
    bullet_world.addSoftBody(soft.get());
    installed.bind(rigid, world.add_rigid_body(mesh));
    installed.bind(*soft, world.add_deforming_body(mesh));
    const MeshId other = world.add_mesh("other", scenes::sphere(1, 1));
    EXPECT_THROW(installed.bind(*soft, world.add_deforming_body(other)), InputError);

    std::uint32_t most = 0;
    for (int i = 0; i < 120; ++i) {
        bullet_world.stepSimulation(btScalar(dt), 0);
        most = std::max(most, installed.reduced_contacts());
    }
    btVector3 velocity(0, 0, 0);
    for (int i = 0; i < soft->m_nodes.size(); ++i)
        velocity += soft->m_nodes[i].m_v / static_cast<btScalar>(soft->m_nodes.size());
    EXPECT_GT(most, 0u);
    EXPECT_GT(velocity.x(), 0.3) << "the soft ball was pushed on";
    EXPECT_LT(rigid.getLinearVelocity().x(), 1.7) << "and the rigid one was slowed down";
    bullet::uninstall(bullet_world);
    bullet_world.removeSoftBody(soft.get());
    bullet_world.removeRigidBody(&rigid);
}

/// Bullet and Pierce side by side, without gravity.
struct BoundWorld {
    World world;
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    bullet::SoftSolver soft_solver;
    btSoftRigidDynamicsWorld bullet_world{&dispatcher, &broadphase, &solver, &configuration,
                                          &soft_solver};
    bullet::Installation& installed = bullet::install(bullet_world, world, {.automatic = false});
    btSphereShape shape{1};

    ~BoundWorld() { bullet::uninstall(bullet_world); }

    BoundWorld() {
        bullet_world.setGravity({0, 0, 0});
        bullet_world.getWorldInfo().m_gravity.setZero();
    }
    std::unique_ptr<btRigidBody> add_rigid(btScalar x) {
        auto rigid = std::make_unique<btRigidBody>(
            btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, {1, 1, 1}));
        rigid->getWorldTransform().setOrigin({x, 0, 0});
        rigid->setInterpolationWorldTransform(rigid->getWorldTransform());
        bullet_world.addRigidBody(rigid.get());
        return rigid;
    }
    std::unique_ptr<btSoftBody> add_soft(const MeshData& mesh, btScalar x) {
        std::vector<btScalar> coordinates;
        for (Vec3f p : mesh.positions) coordinates.insert(coordinates.end(), {p.x + x, p.y, p.z});
        std::vector<int> indices;
        for (const Triangle& t : mesh.triangles)
            for (std::uint32_t v : t.vertex) indices.push_back(static_cast<int>(v));
        std::unique_ptr<btSoftBody> soft(btSoftBodyHelpers::CreateFromTriMesh(
            bullet_world.getWorldInfo(), coordinates.data(), indices.data(),
            static_cast<int>(mesh.triangles.size()), false));
        soft->setTotalMass(1);
        soft->m_cfg.collisions = 0;
        bullet_world.addSoftBody(soft.get());
        return soft;
    }
    void step() { bullet_world.stepSimulation(btScalar(dt), 0); }
};

TEST(InstallTest, ObjectsComeAndGoAtAnyTime) {
    BoundWorld scene;
    const MeshData ball = scenes::sphere(1, 2);
    MeshData torn = ball;
    torn.triangles.erase(torn.triangles.begin() + 11);  // its hole is closed by a triangle more
    const MeshId mesh = scene.world.add_mesh("ball", ball),
                 torn_mesh = scene.world.add_mesh("torn", torn);
    test::Random random(8);
    struct Bound {
        std::unique_ptr<btRigidBody> rigid;
        std::unique_ptr<btSoftBody> soft;
        BodyId body;
    };
    std::vector<Bound> bodies;
    std::uint32_t contacts = 0;
    for (int step = 0; step < 60; ++step) {
        if (bodies.size() < 5) {
            Bound bound;
            const auto x = static_cast<btScalar>(random.uniform(-2, 2));
            if (step % 3 == 0) {
                bound.soft = scene.add_soft(torn, x);
                bound.body = scene.world.add_deforming_body(torn_mesh);
                scene.installed.bind(*bound.soft, bound.body);
            } else {
                bound.rigid = scene.add_rigid(x);
                bound.body = scene.world.add_rigid_body(mesh);
                scene.installed.bind(*bound.rigid, bound.body);
            }
            bodies.push_back(std::move(bound));
        }
        scene.step();
        contacts += scene.installed.reduced_contacts();
        if (step % 4 != 3) continue;
        // The object is deleted; another one may come to the same address.
        const auto gone = bodies.begin() + random.integer(0, static_cast<int>(bodies.size()) - 1);
        if (gone->soft) {
            scene.installed.unbind(*gone->soft);
            scene.bullet_world.removeSoftBody(gone->soft.get());
        } else {
            scene.installed.unbind(*gone->rigid);
            scene.bullet_world.removeRigidBody(gone->rigid.get());
        }
        scene.world.remove_body(gone->body);
        bodies.erase(gone);
    }
    EXPECT_GT(contacts, 200u);
    for (Bound& bound : bodies) {
        if (bound.soft)
            scene.bullet_world.removeSoftBody(bound.soft.get());
        else
            scene.bullet_world.removeRigidBody(bound.rigid.get());
    }
}

TEST(InstallTest, BindingAgainEndsTheLastBinding) {
    BoundWorld scene;
    const MeshId mesh = scene.world.add_mesh("ball", scenes::sphere(1, 2));
    const auto first = scene.add_rigid(0), second = scene.add_rigid(1.5);
    scene.step();
    const int by_bullet = scene.dispatcher.getNumManifolds();
    EXPECT_GT(by_bullet, 0) << "Bullet's own contacts, before anything is bound";
    const BodyId a = scene.world.add_rigid_body(mesh), b = scene.world.add_rigid_body(mesh),
                 c = scene.world.add_rigid_body(mesh);
    scene.installed.bind(*first, a);
    scene.installed.bind(*second, b);
    scene.step();
    EXPECT_GT(scene.installed.reduced_contacts(), 0u);
    scene.installed.bind(*second, c);
    scene.world.remove_body(b);
    scene.step();
    EXPECT_GT(scene.installed.reduced_contacts(), 0u);
    scene.installed.unbind(*second);
    scene.installed.unbind(*second);
    scene.world.remove_body(c);
    scene.step();
    EXPECT_EQ(scene.installed.reduced_contacts(), 0u);
    EXPECT_GT(scene.dispatcher.getNumManifolds(), 0) << "Bullet's own contacts again";
    scene.bullet_world.removeRigidBody(first.get());
    scene.bullet_world.removeRigidBody(second.get());
}

TEST(InstallTest, BindingASoftBodyAgainLeavesNoContactWithItsLastFaces) {
    BoundWorld scene;
    const MeshId mesh = scene.world.add_mesh("ball", scenes::sphere(1, 2));
    const auto first = scene.add_soft(scenes::sphere(1, 2), 0),
               second = scene.add_soft(scenes::sphere(1, 2), 1.5);
    scene.installed.bind(*first, scene.world.add_deforming_body(mesh));
    scene.installed.bind(*second, scene.world.add_deforming_body(mesh));
    scene.step();
    EXPECT_GT(first->m_scontacts.size() + second->m_scontacts.size(), 0);
    scene.installed.bind(*second, scene.world.add_deforming_body(mesh));
    EXPECT_EQ(first->m_scontacts.size(), 0);
    EXPECT_EQ(second->m_scontacts.size(), 0);
    scene.step();
    for (const auto& soft : {&first, &second}) scene.bullet_world.removeSoftBody(soft->get());
}

}  // namespace
}  // namespace pierce
