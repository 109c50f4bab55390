// Soft bodies under SoftSolver: momentum, friction, and when they sleep and wake.
#include <gtest/gtest.h>

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletCollisionCommon.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/bullet/install.hpp"
#include "pierce/bullet/soft_solver.hpp"
#include "scenes/named/shapes.hpp"
#include "scenes/simulate/soft_damping.hpp"

namespace pierce {
namespace {

constexpr btScalar dt = btScalar(1) / 60;
constexpr btScalar gravity = btScalar(9.81);
constexpr btScalar ground_friction = btScalar(0.5);
constexpr int steps_per_second = 60;

std::vector<btVector3> places(const btSoftBody& soft) {
    std::vector<btVector3> result;
    for (int i = 0; i < soft.m_nodes.size(); ++i) result.push_back(soft.m_nodes[i].m_x);
    return result;
}

btVector3 center(const btSoftBody& soft) { return soft.getCenterOfMass(); }

btVector3 velocity(const btSoftBody& soft) {
    btVector3 sum(0, 0, 0);
    for (int i = 0; i < soft.m_nodes.size(); ++i) sum += soft.m_nodes[i].m_v;
    return sum / static_cast<btScalar>(soft.m_nodes.size());
}

bool sleeps(const btSoftBody& soft) { return soft.getActivationState() == ISLAND_SLEEPING; }

/// Soft bodies in a Bullet world, with a wide ground up to z = 0 if there is gravity.
class SoftScene {
public:
    explicit SoftScene(const btVector3& pull) {
        bullet_.setGravity(pull);
        bullet_.getWorldInfo().m_gravity = pull;
        if (pull.length2() > 0) add_box({-200, -200, -10}, {200, 200, 0}, 0, {0, 0, 0});
    }

    ~SoftScene() {
        bullet::uninstall(bullet_);
        for (const auto& soft : softs_) bullet_.removeSoftBody(soft.get());
        for (const auto& box : boxes_) bullet_.removeRigidBody(box.get());
    }

    btSoftBody& add(const MeshData& mesh, const btVector3& at, const btVector3& velocity) {
        std::vector<btScalar> coordinates;
        for (Vec3f p : mesh.positions)
            coordinates.insert(coordinates.end(), {p.x + at.x(), p.y + at.y(), p.z + at.z()});
        std::vector<int> corners;
        for (const Triangle& t : mesh.triangles)
            for (std::uint32_t v : t.vertex) corners.push_back(static_cast<int>(v));
        softs_.emplace_back(btSoftBodyHelpers::CreateFromTriMesh(
            bullet_.getWorldInfo(), coordinates.data(), corners.data(),
            static_cast<int>(mesh.triangles.size()), false));
        btSoftBody& soft = *softs_.back();
        soft.generateBendingConstraints(2);
        soft.m_cfg.piterations = 8;
        soft.m_cfg.kDF = 1;
        soft.m_cfg.kMT = btScalar(0.3);
        soft.m_cfg.kKHR = soft.m_cfg.kCHR = soft.m_cfg.kSHR = 1;
        soft.m_cfg.collisions = 0;
        soft.setTotalMass(1);
        soft.setPose(false, true);
        soft.setVelocity(velocity);
        bullet_.addSoftBody(&soft);
        installed_.bind(soft, world_.add_deforming_body(world_.add_mesh("soft", mesh)));
        return soft;
    }

    btRigidBody& add_box(const btVector3& lower, const btVector3& upper, btScalar mass,
                         const btVector3& at) {
        shapes_.push_back(std::make_unique<btBoxShape>(0.5 * (upper - lower)));
        const btVector3 middle = btScalar(0.5) * (lower + upper),
                        half = btScalar(0.5) * (upper - lower);
        btVector3 inertia(0, 0, 0);
        if (mass > 0) shapes_.back()->calculateLocalInertia(mass, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shapes_.back().get(), inertia);
        info.m_startWorldTransform.setOrigin(middle + at);
        info.m_friction = ground_friction;
        boxes_.push_back(std::make_unique<btRigidBody>(info));
        bullet_.addRigidBody(boxes_.back().get());
        const MeshId mesh = world_.add_mesh(
            "box", scenes::box(bullet::from_bullet(-half), bullet::from_bullet(half)));
        installed_.bind(*boxes_.back(),
                        mass > 0 ? world_.add_rigid_body(mesh) : world_.add_fixed_body(mesh));
        return *boxes_.back();
    }

    void step() {
        bullet_.stepSimulation(dt, 0);
        for (const auto& soft : softs_) scenes::damp_vibration(*soft, btScalar(0.5));
    }
    /// Steps until `done`; false if that takes more than `seconds`.
    template <class Done>
    bool step_until(int seconds, const Done& done) {
        for (int i = 0; i < seconds * steps_per_second; ++i) {
            if (done()) return true;
            step();
        }
        return done();
    }
    std::size_t contact_count() const { return world_.contacts().size(); }

private:
    World world_;
    btSoftBodyRigidBodyCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_{&configuration_};
    btDbvtBroadphase broadphase_;
    btSequentialImpulseConstraintSolver solver_;
    bullet::SoftSolver soft_solver_;
    btSoftRigidDynamicsWorld bullet_{&dispatcher_, &broadphase_, &solver_, &configuration_,
                                     &soft_solver_};
    bullet::Installation& installed_ = bullet::install(bullet_, world_, {.automatic = false});
    std::vector<std::unique_ptr<btBoxShape>> shapes_;
    std::vector<std::unique_ptr<btRigidBody>> boxes_;
    std::vector<std::unique_ptr<btSoftBody>> softs_;
};

const btVector3 down(0, 0, -gravity);
const MeshData ring = scenes::torus(2, 0.5, 30, 10);

TEST(SoftSolverTest, ABodyAtRestSleepsWhereItLiesAndKeepsItsContacts) {
    SoftScene scene(down);
    btSoftBody& soft = scene.add(ring, {0, 0, 2}, {0, 0, 0});
    ASSERT_TRUE(scene.step_until(8, [&] { return sleeps(soft); }));
    const std::vector<btVector3> before = places(soft);
    const std::size_t contacts = scene.contact_count();
    EXPECT_GT(contacts, 10u);
    for (int i = 0; i < steps_per_second; ++i) {
        scene.step();
        ASSERT_TRUE(sleeps(soft));
        EXPECT_EQ(scene.contact_count(), contacts);
        EXPECT_EQ(soft.m_rcontacts.size(), static_cast<int>(contacts)) << "Bullet has them once";
    }
    EXPECT_EQ(places(soft), before) << "to the last bit";
}

TEST(SoftSolverTest, ABodyThatIsPutElsewhereIsNotHeldBack) {
    SoftScene scene(down);
    btSoftBody& soft = scene.add(ring, {0, 0, 2}, {0, 0, 0});
    for (int i = 0; i < 2 * steps_per_second; ++i) scene.step();
    soft.translate({5, 0, 0});
    soft.activate();
    for (int i = 0; i < 4; ++i) {
        scene.step();
        EXPECT_LT(std::fabs(velocity(soft).x()), 0.01) << i;
    }
}

TEST(SoftSolverTest, ASleepingBodyWakesWhenHit) {
    SoftScene scene(down);
    btSoftBody& first = scene.add(ring, {0, 0, 2}, {0, 0, 0});
    ASSERT_TRUE(scene.step_until(8, [&] { return sleeps(first); }));
    const btVector3 before = center(first);
    btSoftBody& second = scene.add(ring, {2, 0, 6}, {0, 0, -3});
    ASSERT_TRUE(scene.step_until(2, [&] { return !sleeps(first); }));
    ASSERT_TRUE(scene.step_until(2, [&] { return center(first).distance(before) > 0.02; }))
        << "it is pushed, not just awake";
    EXPECT_TRUE(scene.step_until(12, [&] { return sleeps(first) && sleeps(second); }))
        << "and both come to rest";
    EXPECT_GT(center(second).z(), 0.5) << "one on the other";
}

TEST(SoftSolverTest, ASleepingBodyWakesWhenARigidOneLandsOnIt) {
    SoftScene scene(down);
    btSoftBody& soft = scene.add(ring, {0, 0, 2}, {0, 0, 0});
    ASSERT_TRUE(scene.step_until(8, [&] { return sleeps(soft); }));
    scene.add_box({-3, -3, -0.2f}, {3, 3, 0.2f}, 1, {0, 0, 4});
    EXPECT_TRUE(scene.step_until(2, [&] { return !sleeps(soft); }));
}

TEST(SoftSolverTest, ASleepingBodyWakesWhenWhatItLiesOnIsLedAway) {
    SoftScene scene(down);
    btRigidBody& plate = scene.add_box({-4, -4, -0.5f}, {4, 4, 0.5f}, 0, {0, 0, 3});
    plate.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    btSoftBody& soft = scene.add(ring, {0, 0, 4.2f}, {0, 0, 0});
    ASSERT_TRUE(scene.step_until(8, [&] { return sleeps(soft); }));
    const btScalar before = center(soft).z();
    plate.forceActivationState(DISABLE_DEACTIVATION);
    for (int i = 0; i < steps_per_second; ++i) {
        btTransform place = plate.getWorldTransform();
        place.getOrigin() += btVector3(0, 0, dt);
        plate.setWorldTransform(place);
        scene.step();
        EXPECT_FALSE(sleeps(soft));
    }
    EXPECT_NEAR(center(soft).z() - before, 1, 0.1);
}

TEST(SoftSolverTest, NothingSleepsInMidAir) {
    SoftScene scene(down);
    btSoftBody& soft = scene.add(ring, {0, 0, 2}, {0, 0, 15});
    for (int i = 0; i < 3 * steps_per_second; ++i) {
        const btScalar before = velocity(soft).z();
        scene.step();
        ASSERT_EQ(soft.getActivationState(), ACTIVE_TAG) << "step " << i;
        EXPECT_NEAR(velocity(soft).z() - before, -gravity * dt, 0.01 * gravity * dt);
    }
}

/// Pull as on a plane that slopes by `degrees` towards x.
btVector3 slope(double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    return bullet::to_bullet(Vec3d{gravity * std::sin(angle), 0, -gravity * std::cos(angle)});
}

TEST(SoftSolverTest, FrictionHoldsABodyOnAGentleSlope) {
    SoftScene scene(slope(20));
    btSoftBody& soft = scene.add(ring, {0, 0, 0.6f}, {0, 0, 0});
    for (int i = 0; i < steps_per_second; ++i) scene.step();
    gDisableDeactivation = true;
    const btVector3 before = center(soft);
    for (int i = 0; i < 5 * steps_per_second; ++i) scene.step();
    gDisableDeactivation = false;
    EXPECT_LT(center(soft).distance(before), 1e-3) << "awake, of a width of 5 in 5 s";
}

TEST(SoftSolverTest, ABodyThatSlidesNeverSleeps) {
    const double degrees = 40;
    const btVector3 pull = slope(degrees);
    SoftScene scene(pull);
    btSoftBody& soft = scene.add(ring, {-150, 0, 0.6f}, {0, 0, 0});
    for (int i = 0; i < steps_per_second; ++i) scene.step();
    const btScalar before = velocity(soft).x();
    for (int i = 0; i < 4 * steps_per_second; ++i) {
        scene.step();
        ASSERT_EQ(soft.getActivationState(), ACTIVE_TAG);
    }
    const btScalar expected = pull.x() + ground_friction * pull.z();  // Coulomb's
    EXPECT_NEAR((velocity(soft).x() - before) / 4, expected, 0.1 * expected);
}

TEST(SoftSolverTest, TwoBodiesThatMeetKeepTheirMomentum) {
    SoftScene scene({0, 0, 0});
    btSoftBody& a = scene.add(scenes::sphere(1, 2), {0, 0, 0}, {2, 0, 0});
    btSoftBody& b = scene.add(scenes::sphere(1, 2), {2.2f, 0.7f, 0.2f}, {-1, 0, 0});
    const btVector3 before = velocity(a) + velocity(b);
    const btScalar first = velocity(a).x();
    for (int i = 0; i < steps_per_second / 2; ++i) {
        scene.step();
        EXPECT_NEAR((velocity(a) + velocity(b)).distance(before), 0, 1e-3)
            << "to Bullet's rounding";
    }
    EXPECT_LT(velocity(a).x(), first - 0.5) << "they have met";
}

TEST(SoftSolverTest, NodesThatAreHeldStayWhereTheyAre) {
    SoftScene scene({0, 0, -1});
    btSoftBody& held = scene.add(ring, {0, 0, 3}, {0, 0, 0});
    for (int i = 0; i < held.m_nodes.size(); i += 6) held.setMass(i, 0);
    const std::vector<btVector3> before = places(held);
    btSoftBody& other = scene.add(ring, {1, 0, 4.2f}, {0, 0, -3});
    other.setTotalMass(5);
    bool have_met = false;
    for (int i = 0; i < 2 * steps_per_second; ++i) {
        scene.step();
        have_met = have_met || scene.contact_count() > 0;
        for (int n = 0; n < held.m_nodes.size(); n += 6)
            ASSERT_EQ(held.m_nodes[n].m_x, before[static_cast<std::size_t>(n)]) << "step " << i;
    }
    EXPECT_TRUE(have_met);
}

TEST(SoftSolverTest, SoftContactsCarryABody) {
    for (const btScalar hardness : {btScalar(0.1), btScalar(1)}) {  // 0.1 is Bullet's default
        SoftScene scene(down);
        btSoftBody& soft = scene.add(ring, {0, 0, 0.6f}, {0, 0, 0});
        soft.m_cfg.kKHR = hardness;
        soft.m_cfg.piterations = 1;
        for (int i = 0; i < 4 * steps_per_second; ++i) scene.step();
        btScalar lowest = 1;
        for (const btVector3& place : places(soft)) lowest = btMin(place.z(), lowest);
        EXPECT_GT(lowest, hardness < 1 ? -0.1 : -0.03) << "hardness " << hardness;
    }
}

}  // namespace
}  // namespace pierce
