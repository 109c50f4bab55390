// Pierce installed in stock Bullet worlds: what is bound, followed, left alone and given back.
#include "pierce/bullet/install.hpp"

#include <gtest/gtest.h>

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"
#include "scenes/named/hard_meshes.hpp"
#include "scenes/named/shapes.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

constexpr btScalar dt = btScalar(1.0 / 60);

void add_triangles(btTriangleMesh& triangles, const MeshData& mesh) {
    for (const Triangle& t : mesh.triangles)
        triangles.addTriangle(bullet::to_bullet(mesh.positions[t.vertex[0]]),
                              bullet::to_bullet(mesh.positions[t.vertex[1]]),
                              bullet::to_bullet(mesh.positions[t.vertex[2]]));
}

/// A shape of Bullet's that reads a mesh in place.
struct MeshShape {
    btTriangleMesh triangles;
    std::unique_ptr<btCollisionShape> shape;

    static std::unique_ptr<MeshShape> gimpact(const MeshData& mesh) {
        auto made = std::make_unique<MeshShape>();
        add_triangles(made->triangles, mesh);
        auto shape = std::make_unique<btGImpactMeshShape>(&made->triangles);
        shape->setMargin(btScalar(0.01));
        shape->updateBound();
        made->shape = std::move(shape);
        return made;
    }
    static std::unique_ptr<MeshShape> bvh(const MeshData& mesh) {
        auto made = std::make_unique<MeshShape>();
        add_triangles(made->triangles, mesh);
        made->shape = std::make_unique<btBvhTriangleMeshShape>(&made->triangles, true);
        return made;
    }
};

/// A stock world for rigid and soft bodies, as Bullet's examples make it.
struct StockWorld {
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btSoftRigidDynamicsWorld bullet{&dispatcher, &broadphase, &solver, &configuration};
    World contacts{bvh_backend()};
    std::vector<std::unique_ptr<btRigidBody>> rigid;
    std::vector<std::unique_ptr<btSoftBody>> soft;

    explicit StockWorld(btScalar gravity = 0) {
        btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
        bullet.setGravity({0, 0, -gravity});
        bullet.getWorldInfo().m_gravity.setValue(0, 0, -gravity);
    }
    ~StockWorld() {
        for (const auto& body : rigid) bullet.removeRigidBody(body.get());
        for (const auto& body : soft) bullet.removeSoftBody(body.get());
        bullet::uninstall(bullet);
    }
    StockWorld(const StockWorld&) = delete;
    StockWorld& operator=(const StockWorld&) = delete;

    btRigidBody& add(btCollisionShape& shape, btScalar mass, const btTransform& at) {
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, {mass, mass, mass});
        info.m_startWorldTransform = at;
        rigid.push_back(std::make_unique<btRigidBody>(info));
        bullet.addRigidBody(rigid.back().get());
        return *rigid.back();
    }
    btSoftBody& add_soft(const MeshData& mesh, const btVector3& at) {
        std::vector<btScalar> coordinates;
        for (Vec3f p : mesh.positions)
            coordinates.insert(coordinates.end(), {p.x + at.x(), p.y + at.y(), p.z + at.z()});
        std::vector<int> indices;
        for (const Triangle& t : mesh.triangles)
            for (std::uint32_t v : t.vertex) indices.push_back(static_cast<int>(v));
        soft.emplace_back(btSoftBodyHelpers::CreateFromTriMesh(
            bullet.getWorldInfo(), coordinates.data(), indices.data(),
            static_cast<int>(mesh.triangles.size()), false));
        soft.back()->setTotalMass(1);
        bullet.addSoftBody(soft.back().get());
        return *soft.back();
    }
    void remove_rigid(std::size_t which) {
        bullet.removeRigidBody(rigid[which].get());
        rigid.erase(rigid.begin() + static_cast<std::ptrdiff_t>(which));
    }
    void remove_soft(std::size_t which) {
        bullet.removeSoftBody(soft[which].get());
        soft.erase(soft.begin() + static_cast<std::ptrdiff_t>(which));
    }
    int points() {
        int count = 0;
        for (int m = 0; m < dispatcher.getNumManifolds(); ++m)
            count += dispatcher.getManifoldByIndexInternal(m)->getNumContacts();
        return count;
    }
};

btTransform at(btScalar x, btScalar y, btScalar z) {
    return btTransform(btQuaternion::getIdentity(), {x, y, z});
}

const MeshData ring = scenes::torus(1, 0.4, 24, 10);

TEST(InstallTest, EveryKindOfTriangleMeshIsBoundAndNothingElse) {
    StockWorld scene;
    const auto gimpact = MeshShape::gimpact(ring), bvh = MeshShape::bvh(ring);
    btScaledBvhTriangleMeshShape scaled(static_cast<btBvhTriangleMeshShape*>(bvh->shape.get()),
                                        {2, 2, 2});
    MeshData sheet = scenes::grid(2, 2, 4, 4);
    const auto terrain = MeshShape::bvh(sheet);
    btBoxShape box({1, 1, 1});
    btGImpactCompoundShape compound;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts);
    btRigidBody& moving = scene.add(*gimpact->shape, 1, at(0, 0, 0));
    btRigidBody& twin = scene.add(*gimpact->shape, 1, at(0.3f, 0, 0.3f));
    btRigidBody& standing = scene.add(*bvh->shape, 0, at(0, 0.4f, -0.3f));
    btRigidBody& large = scene.add(scaled, 0, at(0, 0, 0.4f));
    btRigidBody& ground = scene.add(*terrain->shape, 0, at(0, 0, 0));
    btRigidBody& solid = scene.add(box, 1, at(0, 0, 9));
    btSoftBody& soft = scene.add_soft(ring, {0.5f, 0, 0.2f});
    btSoftBody& cloth = scene.add_soft(sheet, {0, 0, 5});
    scene.bullet.stepSimulation(dt, 0);
    for (const btCollisionObject* bound :
         std::initializer_list<const btCollisionObject*>{&moving, &twin, &standing, &large, &soft})
        EXPECT_TRUE(installed.body_of(*bound));
    EXPECT_FALSE(installed.body_of(solid));
    EXPECT_FALSE(installed.body_of(ground));
    EXPECT_FALSE(installed.body_of(cloth));
    ASSERT_EQ(installed.left_to_bullet().size(), 2u);
    EXPECT_EQ(installed.left_to_bullet()[0].object, &ground);
    EXPECT_NE(installed.left_to_bullet()[0].why.find("no inside"), std::string::npos);
    EXPECT_EQ(installed.left_to_bullet()[1].object, &cloth);
    EXPECT_EQ(scene.contacts.mesh_of(installed.body_of(moving)),
              scene.contacts.mesh_of(installed.body_of(twin)))
        << "one mesh for one shape";
    const Mesh& small = scene.contacts.mesh(scene.contacts.mesh_of(installed.body_of(standing)));
    const Mesh& twice = scene.contacts.mesh(scene.contacts.mesh_of(installed.body_of(large)));
    EXPECT_EQ(small.positions().size(), ring.positions.size());
    EXPECT_EQ(small.triangles().size(), ring.triangles.size());
    EXPECT_NEAR(twice.traits().volume, 8 * small.traits().volume, 1e-3);
    EXPECT_EQ(scene.contacts.motion_of(installed.body_of(standing)), Motion::fixed);
    EXPECT_EQ(scene.contacts.motion_of(installed.body_of(moving)), Motion::rigid);
    EXPECT_EQ(scene.contacts.motion_of(installed.body_of(soft)), Motion::deforming);
    EXPECT_GT(installed.reduced_contacts(), 0u);
}

/// The contacts of a new world without memory, with the bodies of the installed one where Bullet
/// has them.
void contacts_from_nothing(const StockWorld& scene, const bullet::Installation& installed,
                           std::vector<double>& depths) {
    World fresh(bvh_backend(), {.temporal = Temporal::off});
    const auto add = [&](const btCollisionObject& object, const btSoftBody* soft) {
        const BodyId body = installed.body_of(object);
        if (!body) return;
        const Mesh& mesh = scene.contacts.mesh(scene.contacts.mesh_of(body));
        const MeshId copy = fresh.add_mesh("copy", mesh.data());
        if (soft == nullptr) {
            const Pose pose = bullet::from_bullet(object.getWorldTransform());
            if (object.isStaticObject())
                fresh.add_fixed_body(copy, pose);
            else
                fresh.add_rigid_body(copy, pose);
            return;
        }
        std::vector<Vec3f> positions;
        for (std::uint32_t v = 0; v < mesh.positions().size(); ++v)
            positions.push_back(to_float(scene.contacts.vertex_position(body, v)));
        fresh.set_collision(fresh.add_deforming_body(copy, positions), {.self = SelfCollision::on});
    };
    for (const auto& body : scene.rigid) add(*body, nullptr);
    for (const auto& body : scene.soft) add(*body, body.get());
    fresh.detect();
    for (const Contact& c : fresh.contacts()) depths.push_back(c.penetration_depth());
}

TEST(InstallTest, FollowsWhatIsAddedRemovedTeleportedAndChanged) {
    test::Random random(11);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    StockWorld scene;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts);
    const auto first = MeshShape::gimpact(ring),
               second = MeshShape::gimpact(scenes::sphere(0.8, 2));
    const auto place = [&] {
        btTransform result = at(btScalar(random.uniform(-1.5, 1.5)),
                                btScalar(random.uniform(-1.5, 1.5)),
                                btScalar(random.uniform(-1, 1)));
        result.setRotation(btQuaternion(btScalar(random.uniform(-3, 3)),
                                        btScalar(random.uniform(-3, 3)),
                                        btScalar(random.uniform(-3, 3))));
        return result;
    };
    std::size_t compared = 0, removed = 0;
    for (int step = 0; step < 80; ++step) {
        switch (random.integer(0, 5)) {
            case 0:
                if (scene.rigid.size() < 6)
                    scene.add(random.integer(0, 1) ? *first->shape : *second->shape,
                              random.integer(0, 2) ? 1 : 0, place());
                break;
            case 1:
                if (scene.soft.size() < 2) scene.add_soft(ring, place().getOrigin());
                break;
            case 2:
                if (scene.rigid.empty()) break;
                scene.remove_rigid(static_cast<std::size_t>(
                    random.integer(0, static_cast<int>(scene.rigid.size()) - 1)));
                ++removed;
                break;
            case 3:
                if (scene.soft.empty()) break;
                scene.remove_soft(0);
                ++removed;
                break;
            case 4:
                if (scene.rigid.empty()) break;
                scene.rigid.front()->setWorldTransform(place());
                scene.rigid.front()->activate();
                break;
            default:
                if (scene.rigid.empty()) break;
                scene.rigid.back()->setCollisionShape(random.integer(0, 1) ? first->shape.get()
                                                                           : second->shape.get());
                break;
        }
        // Nothing pushes rigid bodies, so they stay where contacts were found.
        for (const auto& body : scene.rigid)
            body->setCollisionFlags(body->getCollisionFlags() |
                                    btCollisionObject::CF_NO_CONTACT_RESPONSE);
        scene.bullet.stepSimulation(dt, 0);
        std::vector<double> expected, found;
        contacts_from_nothing(scene, installed, expected);
        for (const Contact& c : scene.contacts.contacts()) found.push_back(c.penetration_depth());
        std::ranges::sort(expected);
        std::ranges::sort(found);
        ASSERT_EQ(found.size(), expected.size()) << "step " << step;
        for (std::size_t i = 0; i < found.size(); ++i)
            ASSERT_NEAR(found[i], expected[i], 1e-6) << "step " << step;
        compared += found.size();
    }
    EXPECT_GT(compared, 1000u);
    EXPECT_GT(removed, 10u);
}

TEST(InstallTest, WhatSleepsKeepsItsContactsAndIsNotLookedAt) {
    StockWorld scene(10);
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts);
    const auto floor = MeshShape::bvh(scenes::box({-4, -4, -1}, {4, 4, 0})),
               shape = MeshShape::gimpact(ring);
    scene.add(*floor->shape, 0, at(0, 0, 0));
    btRigidBody& body = scene.add(*shape->shape, 1, at(0, 0, 0.45f));
    for (int i = 0; i < 600 && body.isActive(); ++i) scene.bullet.stepSimulation(dt, 0);
    ASSERT_FALSE(body.isActive());
    const std::uint32_t reached = installed.reduced_contacts();
    const int points = scene.points();
    EXPECT_GT(reached, 2u);
    EXPECT_NEAR(body.getWorldTransform().getOrigin().z(), 0.4, 0.02);
    for (int i = 0; i < 10; ++i) {
        scene.bullet.stepSimulation(dt, 0);
        EXPECT_FALSE(installed.has_detected());
        EXPECT_EQ(installed.reduced_contacts(), reached);
        EXPECT_EQ(scene.points(), points);
    }
    body.setWorldTransform(at(0, 0, 3));  // without a word to anyone
    scene.bullet.updateSingleAabb(&body);
    scene.bullet.stepSimulation(dt, 0);
    EXPECT_TRUE(installed.has_detected());
    EXPECT_EQ(installed.reduced_contacts(), 0u);
    EXPECT_TRUE(scene.contacts.contacts().empty());
}

// The new list is as long as the last one and lies where that did.
TEST(InstallTest, ContactsOfStepsThatTheWorldsOwnerTakesAreSeen) {
    StockWorld scene;
    World& contacts = scene.contacts;
    const auto shape = MeshShape::gimpact(ring);
    const Pose place{{9, 0, 0}, {0, 0, 0, 1}}, beside{{9.3, 0, 0.3}, {0, 0, 0, 1}};
    const MeshId mesh = contacts.add_mesh("ring", ring);
    const BodyId a = contacts.add_rigid_body(mesh, place),
                 b = contacts.add_rigid_body(mesh, beside);
    contacts.exclude(a, b);
    bullet::Installation& installed = bullet::install(scene.bullet, contacts);
    scene.add(*shape->shape, 1, at(0, 0, 0));
    scene.add(*shape->shape, 1, at(0.3f, 0, 0.3f));
    scene.bullet.performDiscreteCollisionDetection();
    EXPECT_GT(installed.reduced_contacts(), 0u);
    const Contact first = contacts.contacts().front();
    const std::size_t count = contacts.contacts().size();
    const Contact* const last = contacts.contacts().data();

    contacts.exclude(first.a, first.b);
    contacts.include(a, b);
    for (int i = 0; i < 2; ++i) contacts.detect();
    ASSERT_EQ(contacts.contacts().size(), count);
    EXPECT_EQ(contacts.contacts().data(), last);
    scene.bullet.performDiscreteCollisionDetection();
    EXPECT_EQ(installed.reduced_contacts(), 0u) << "these two are left out";
}

TEST(InstallTest, PairsThatBulletFiltersOutGetNoContacts) {
    StockWorld scene;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts);
    const auto shape = MeshShape::gimpact(ring);
    btRigidBody& a = scene.add(*shape->shape, 1, at(0, 0, 0));
    btRigidBody& b = scene.add(*shape->shape, 1, at(0.3f, 0, 0.3f));
    a.setIgnoreCollisionCheck(&b, true);
    scene.bullet.performDiscreteCollisionDetection();
    EXPECT_EQ(installed.reduced_contacts(), 0u);
    a.setIgnoreCollisionCheck(&b, false);
    scene.bullet.performDiscreteCollisionDetection();
    EXPECT_GT(installed.reduced_contacts(), 0u);
    EXPECT_LE(installed.reduced_contacts(), 24u) << "reduced";
}

TEST(InstallTest, AnAnchorKeepsWhatItHoldsFromColliding) {
    for (const bool keeps : {false, true}) {
        StockWorld scene;
        bullet::install(scene.bullet, scene.contacts);
        const auto shape = MeshShape::gimpact(ring);
        btRigidBody& rigid = scene.add(*shape->shape, 1, at(0, 0, 0));
        btSoftBody& soft = scene.add_soft(ring, {0.2f, 0, 0.3f});
        soft.appendAnchor(0, &rigid, keeps);
        scene.bullet.stepSimulation(dt, 0);
        EXPECT_EQ(soft.m_rcontacts.size() == 0, keeps);
    }
}

TEST(InstallTest, AFastObjectMayBeBoundToAFixedBody) {
    StockWorld scene;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts,
                                                      {.automatic = false});
    const auto shape = MeshShape::gimpact(ring);
    btRigidBody& rigid = scene.add(*shape->shape, 1, at(0, 0, 0));
    installed.bind(rigid, scene.contacts.add_fixed_body(scene.contacts.add_mesh("ring", ring)));
    rigid.setCcdMotionThreshold(btScalar(0.01));
    rigid.setLinearVelocity({0, 0, -50});
    scene.add(*shape->shape, 0, at(0, 0, -2));
    for (int step = 0; step < 5; ++step) EXPECT_NO_THROW(scene.bullet.stepSimulation(dt, 0));
}

TEST(InstallTest, BodiesOfAnotherKindAreNotBound) {
    StockWorld scene;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts,
                                                      {.automatic = false});
    const auto shape = MeshShape::gimpact(ring);
    btRigidBody& rigid = scene.add(*shape->shape, 1, at(0, 0, 0));
    btSoftBody& soft = scene.add_soft(ring, {0, 0, 5});
    const MeshId mesh = scene.contacts.add_mesh("ring", ring);
    const BodyId moves = scene.contacts.add_rigid_body(mesh),
                 deforms = scene.contacts.add_deforming_body(mesh);
    EXPECT_THROW(installed.bind(rigid, BodyId{}), InputError);
    EXPECT_THROW(installed.bind(rigid, deforms), InputError);
    EXPECT_THROW(installed.bind(soft, moves), InputError);
    installed.bind(rigid, moves);
    installed.bind(soft, deforms);
    scene.bullet.stepSimulation(dt, 0);
}

TEST(InstallTest, AStepThatCannotFollowABodyFailsUntilItIsUnbound) {
    StockWorld scene;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts,
                                                      {.automatic = false});
    const auto shape = MeshShape::gimpact(ring);
    btRigidBody& rigid = scene.add(*shape->shape, 1, at(0, 0, 0));
    const BodyId body = scene.contacts.add_rigid_body(scene.contacts.add_mesh("ring", ring));
    installed.bind(rigid, body);
    scene.bullet.stepSimulation(dt, 0);
    scene.contacts.remove_body(body);
    rigid.setWorldTransform(at(1, 0, 0));
    for (int step = 0; step < 2; ++step)
        EXPECT_THROW(scene.bullet.stepSimulation(dt, 0), InputError);
    installed.unbind(rigid);
    EXPECT_NO_THROW(scene.bullet.stepSimulation(dt, 0));
}

TEST(InstallTest, UninstallGivesTheWorldBack) {
    StockWorld scene;
    const auto shape = MeshShape::gimpact(ring);
    scene.add(*shape->shape, 1, at(0, 0, 0));
    scene.add(*shape->shape, 1, at(0.3f, 0, 0.3f));
    const MeshId kept = scene.contacts.add_mesh("kept", ring);
    const BodyId own = scene.contacts.add_fixed_body(kept, {{9, 9, 9}, {0, 0, 0, 1}});
    scene.bullet.performDiscreteCollisionDetection();
    const int by_bullet = scene.points();
    btCollisionConfiguration* const before = scene.dispatcher.getCollisionConfiguration();
    for (int round = 0; round < 3; ++round) {
        const bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts);
        EXPECT_THROW(bullet::install(scene.bullet, scene.contacts), InputError);
        scene.bullet.performDiscreteCollisionDetection();
        EXPECT_EQ(static_cast<std::uint32_t>(scene.points()), installed.reduced_contacts());
        EXPECT_GT(scene.points(), 0);
        bullet::uninstall(scene.bullet);
        EXPECT_EQ(scene.dispatcher.getCollisionConfiguration(), before);
        EXPECT_EQ(scene.dispatcher.getNearCallback(), &btCollisionDispatcher::defaultNearCallback);
        scene.bullet.performDiscreteCollisionDetection();
        EXPECT_EQ(scene.points(), by_bullet);
        scene.contacts.detect();
        EXPECT_EQ(scene.contacts.body_boxes().size(), 1u) << "only the one that was there";
    }
    EXPECT_EQ(scene.contacts.mesh_of(own), kept);
    bullet::uninstall(scene.bullet);
    EXPECT_THROW(bullet::install(scene.bullet, scene.contacts, {.most_per_pair = 5}), InputError);
}

TEST(InstallTest, UninstallLeavesAnotherWorldOfTheDispatcherAlone) {
    StockWorld scene;
    bullet::install(scene.bullet, scene.contacts);
    btDiscreteDynamicsWorld other(&scene.dispatcher, &scene.broadphase, &scene.solver,
                                  scene.dispatcher.getCollisionConfiguration());
    bullet::uninstall(other);
    EXPECT_THROW(bullet::install(scene.bullet, scene.contacts), InputError) << "still installed";
    scene.bullet.stepSimulation(dt, 0);
}

TEST(InstallTest, ASoftBodyMeetsItself) {
    StockWorld scene;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts);
    btSoftBody& soft = scene.add_soft(ring, {0, 0, 0});
    scene.bullet.stepSimulation(dt, 0);
    EXPECT_TRUE(scene.contacts.contacts().empty());
    // One side of the ring goes into the other one.
    for (int i = 0; i < soft.m_nodes.size(); ++i)
        if (soft.m_nodes[i].m_x.x() > 0.5f)
            soft.m_nodes[i].m_x.setX(soft.m_nodes[i].m_x.x() - 1.9f);
    scene.bullet.stepSimulation(dt, 0);
    const auto self = std::ranges::count_if(scene.contacts.contacts(),
                                            [](const Contact& c) { return c.a == c.b; });
    EXPECT_GT(self, 5);
    EXPECT_EQ(soft.m_scontacts.size(), self);
    // Another binding has other faces.
    installed.bind(soft, scene.contacts.add_deforming_body(scene.contacts.add_mesh("ring", ring)));
    EXPECT_EQ(soft.m_scontacts.size(), 0);
}

class CountPoints : public btIDebugDraw {
public:
    int points = 0;
    void drawLine(const btVector3&, const btVector3&, const btVector3&) override {}
    void drawContactPoint(const btVector3&, const btVector3&, btScalar, int,
                          const btVector3&) override {
        ++points;
    }
    void reportErrorWarning(const char*) override {}
    void draw3dText(const btVector3&, const char*) override {}
    void setDebugMode(int) override {}
    int getDebugMode() const override { return DBG_DrawContactPoints | DBG_DrawAabb; }
};

TEST(InstallTest, TheDebugDrawerShowsContacts) {
    StockWorld scene;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts);
    CountPoints drawer;
    scene.bullet.setDebugDrawer(&drawer);
    const auto shape = MeshShape::gimpact(ring);
    scene.add(*shape->shape, 1, at(0, 0, 0));
    scene.add(*shape->shape, 1, at(0.3f, 0, 0.3f));
    scene.bullet.performDiscreteCollisionDetection();
    scene.bullet.debugDrawWorld();
    EXPECT_EQ(static_cast<std::uint32_t>(drawer.points), installed.reduced_contacts());
    EXPECT_GT(drawer.points, 0);
    scene.add_soft(ring, {-0.4f, 0, 0.2f});
    scene.bullet.stepSimulation(dt, 0);
    drawer.points = 0;
    scene.bullet.debugDrawWorld();
    EXPECT_GT(drawer.points, scene.points()) << "those of soft bodies, too";
}

int callbacks = 0;
bool count_point(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int index_a,
                 const btCollisionObjectWrapper*, int, int index_b) {
    ++callbacks;
    EXPECT_NE(index_a < 0, index_b < 0) << "one side is a vertex";
    point.m_combinedFriction = btScalar(0.125);
    return true;
}

/// Shows the points of two bodies of a shape that overlap to a program's callback.
void show_points(StockWorld& scene, btCollisionShape& shape, ContactAddedCallback callback) {
    bullet::install(scene.bullet, scene.contacts);
    scene.add(shape, 1, at(0, 0, 0));
    btRigidBody& special = scene.add(shape, 1, at(0.3f, 0, 0.3f));
    special.setCollisionFlags(special.getCollisionFlags() |
                              btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    callbacks = 0;
    gContactAddedCallback = callback;
    scene.bullet.performDiscreteCollisionDetection();
    gContactAddedCallback = nullptr;
}

TEST(InstallTest, TheProgramsOwnCallbackChangesPoints) {
    StockWorld scene;
    const auto shape = MeshShape::gimpact(ring);
    show_points(scene, *shape->shape, count_point);
    EXPECT_GT(callbacks, 0);
    EXPECT_EQ(callbacks, scene.points());
    EXPECT_EQ(scene.dispatcher.getManifoldByIndexInternal(0)->getContactPoint(0).m_combinedFriction,
              btScalar(0.125));
}

int points_without_directions = 0;

bool looks_at_directions(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                         const btCollisionObjectWrapper*, int, int) {
    ++callbacks;
    const btVector3& normal = point.m_normalWorldOnB;
    const bool right = std::fabs(point.m_lateralFrictionDir1.length() - 1) < 1e-5f &&
                       std::fabs(point.m_lateralFrictionDir2.length() - 1) < 1e-5f &&
                       std::fabs(point.m_lateralFrictionDir1.dot(normal)) < 1e-5f &&
                       std::fabs(point.m_lateralFrictionDir2.dot(normal)) < 1e-5f;
    points_without_directions += !right;
    return false;
}

/// Belts move what lies on them along the directions of friction that a point comes with.
TEST(InstallTest, PointsComeWithDirectionsOfFriction) {
    StockWorld scene;
    const auto shape = MeshShape::gimpact(ring);
    points_without_directions = 0;
    show_points(scene, *shape->shape, looks_at_directions);
    EXPECT_GT(callbacks, 0);
    EXPECT_EQ(points_without_directions, 0);
}

TEST(InstallTest, APoolThatMayNotGrowHoldsTheDeepestPoints) {
    btDefaultCollisionConstructionInfo small;
    small.m_defaultMaxPersistentManifoldPoolSize = 1;
    btSoftBodyRigidBodyCollisionConfiguration configuration(small);
    btCollisionDispatcher dispatcher(&configuration);
    dispatcher.setDispatcherFlags(dispatcher.getDispatcherFlags() |
                                  btCollisionDispatcher::CD_DISABLE_CONTACTPOOL_DYNAMIC_ALLOCATION);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    World contacts{bvh_backend()};
    bullet::install(world, contacts);
    const auto shape = MeshShape::gimpact(ring);
    std::vector<std::unique_ptr<btRigidBody>> rings;
    for (const float z : {0.f, 0.2f, 0.4f}) {
        btRigidBody::btRigidBodyConstructionInfo info(1, nullptr, shape->shape.get(), {1, 1, 1});
        info.m_startWorldTransform = at(0.3f * z, 0, z);
        world.addRigidBody(rings.emplace_back(std::make_unique<btRigidBody>(info)).get());
    }
    for (int step = 0; step < 3; ++step) {
        world.performDiscreteCollisionDetection();
        ASSERT_EQ(dispatcher.getNumManifolds(), 1);
        const btPersistentManifold& only = *dispatcher.getManifoldByIndexInternal(0);
        ASSERT_EQ(only.getNumContacts(), MANIFOLD_CACHE_SIZE);
        double deepest = 0, kept = 0;
        for (const Contact& c : contacts.contacts()) {
            const bool is_pair = (c.a.index == 0 && c.b.index == 1);
            if (is_pair) deepest = std::max(deepest, c.penetration_depth());
        }
        for (int i = 0; i < only.getNumContacts(); ++i)
            kept = std::max(kept, -static_cast<double>(only.getContactPoint(i).getDistance()));
        EXPECT_GT(kept, 0.5 * deepest);
    }
    bullet::uninstall(world);
    for (const auto& ring_body : rings) world.removeRigidBody(ring_body.get());
}

/// Impulses stay with their vertices: a body at rest that may not sleep is held up by them.
TEST(InstallTest, PointsKeepTheirImpulsesAtRest) {
    StockWorld scene(10);
    bullet::install(scene.bullet, scene.contacts);
    const auto floor = MeshShape::bvh(scenes::box({-4, -4, -1}, {4, 4, 0})),
               shape = MeshShape::gimpact(scenes::box({-1, -1, -1}, {1, 1, 1}));
    scene.add(*floor->shape, 0, at(0, 0, 0));
    btRigidBody& body = scene.add(*shape->shape, 1, at(0.1f, 0.2f, 1));
    body.setActivationState(DISABLE_DEACTIVATION);
    for (int i = 0; i < 240; ++i) scene.bullet.stepSimulation(dt, 0);
    double push = 0;
    int youngest = 1000;
    for (int m = 0; m < scene.dispatcher.getNumManifolds(); ++m) {
        const btPersistentManifold& manifold = *scene.dispatcher.getManifoldByIndexInternal(m);
        for (int i = 0; i < manifold.getNumContacts(); ++i) {
            push += manifold.getContactPoint(i).getAppliedImpulse();
            youngest = std::min(youngest, manifold.getContactPoint(i).getLifeTime());
        }
    }
    EXPECT_NEAR(push, 10 * dt, 0.02 * 10 * dt) << "they carry its weight";
    EXPECT_GT(youngest, 10);
}

/// Linked rings whose edges overlap by 0.03, while a vertex of each only touches the other:
/// contacts by separation would push one ring through the other.
/// How far below a thin plate, or above it, a body is after some steps that would have taken it
/// far through.
btScalar height_after(const MeshData& shape, const btQuaternion& turn, const btVector3& spin,
                      btScalar threshold, bool continuous = true) {
    StockWorld scene;
    const auto plate = MeshShape::bvh(scenes::box({-2, -2, -0.01}, {2, 2, 0.01})),
               bullet = MeshShape::gimpact(shape);
    auto& installed = bullet::install(scene.bullet, scene.contacts, {.continuous = continuous});
    scene.add(*plate->shape, 0, at(0, 0, 0));
    btRigidBody& body = scene.add(*bullet->shape, 1, btTransform(turn, {0.1f, 0.2f, 1}));
    body.setLinearVelocity({3, 0, -150});
    body.setAngularVelocity(spin);
    body.setCcdMotionThreshold(threshold);
    for (int step = 0; step < 4; ++step) {
        scene.bullet.stepSimulation(dt, 0);
        EXPECT_LT(body.getLinearVelocity().length(), 151);
        // Looking ahead leaves the world as it is.
        EXPECT_NO_THROW(
            scene.contacts.explain(installed.body_of(*scene.rigid[0]), installed.body_of(body), 0));
        if (body.getWorldTransform().getOrigin().z() < -1) break;
    }
    return body.getWorldTransform().getOrigin().z();
}

TEST(InstallTest, AFastBodyOfAnyShapeStopsAtAPlate) {
    test::Random random(31);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    const MeshData shapes[] = {scenes::torus(0.12, 0.05, 12, 8),
                               scenes::box({-0.1f, -0.15f, -0.05f}, {0.1f, 0.15f, 0.05f}),
                               scenes::sphere(0.1, 2)};
    const btQuaternion upright = btQuaternion::getIdentity();
    EXPECT_LT(height_after(shapes[1], upright, {0, 0, 0}, 0), -1) << "it is never fast";
    EXPECT_LT(height_after(shapes[1], upright, {0, 0, 0}, btScalar(0.05), false), -1);
    EXPECT_LT(height_after(shapes[1], upright, {0, 0, 0}, 9), -1) << "it is not fast enough";
    EXPECT_GT(height_after(shapes[1], upright, {0, 0, 0}, btScalar(0.05)), 0.03) << "flat";
    for (int i = 0; i < 30; ++i) {
        const Quaternion q = random.rotation();
        const btQuaternion turn(btScalar(q.x), btScalar(q.y), btScalar(q.z), btScalar(q.w));
        const Vec3d spin = random.in_box(i % 2 == 0 ? 0 : 20);
        EXPECT_GT(height_after(shapes[i % 3], turn, bullet::to_bullet(spin), btScalar(0.05)), 0)
            << "shot " << i;
    }
}

TEST(InstallTest, LooksBetweenStepsTakeNothingFromSteps) {
    const auto plate = MeshShape::bvh(scenes::box({-5, -5, -0.05f}, {5, 5, 0.05f})),
               ball = MeshShape::gimpact(scenes::sphere(0.3, 2));
    btSphereShape sphere(1);
    btBoxShape box({1, 1, 1});
    for (int shot = 0; shot < 8; ++shot) {
        StockWorld scene;
        // A pair that is Bullet's: in a look between steps it may be the only one.
        scene.add(sphere, 1, at(30, 0, 0)).setActivationState(DISABLE_DEACTIVATION);
        scene.add(box, 0, at(30, 0, -1.9f));
        scene.add(*plate->shape, 0, at(0, 0, 0));
        bullet::install(scene.bullet, scene.contacts);
        const auto aside = static_cast<btScalar>(shot);
        btRigidBody& fast = scene.add(*ball->shape, 1, at(0.1f * aside, 0, 3 + 0.093f * aside));
        fast.setCcdMotionThreshold(0.1f);
        fast.setLinearVelocity({0, 0, -100});
        for (int step = 0; step < 10; ++step) {
            scene.bullet.stepSimulation(dt, 0);
            scene.bullet.performDiscreteCollisionDetection();
        }
        EXPECT_GT(fast.getWorldTransform().getOrigin().z(), 0) << "shot " << shot;
    }
}

TEST(InstallTest, AProgramThatOnlyLooksGetsContacts) {
    const auto mesh = MeshShape::gimpact(ring);
    btSphereShape sphere(1);
    StockWorld scene;
    scene.add(sphere, 1, at(30, 0, 0));
    scene.add(sphere, 1, at(31, 0, 0));
    auto& installed = bullet::install(scene.bullet, scene.contacts);
    scene.bullet.performDiscreteCollisionDetection();
    btRigidBody& one = scene.add(*mesh->shape, 1, at(0, 0, 0));
    scene.add(*mesh->shape, 1, at(0.3f, 0, 0.3f));
    scene.bullet.performDiscreteCollisionDetection();
    EXPECT_TRUE(installed.body_of(one));
    EXPECT_GT(installed.reduced_contacts(), 0u);
}

int manifolds_begun = 0, manifolds_ended = 0;

TEST(InstallTest, ManifoldsBeginAndEndOnce) {
    gContactStartedCallback = [](btPersistentManifold* const&) { ++manifolds_begun; };
    gContactEndedCallback = [](btPersistentManifold* const&) { ++manifolds_ended; };
    {
        const auto mesh = MeshShape::gimpact(ring);
        StockWorld scene;
        bullet::install(scene.bullet, scene.contacts);
        scene.add(*mesh->shape, 0, at(0, 0, 0));
        btRigidBody& moving = scene.add(*mesh->shape, 1, at(0.3f, 0, 0.3f));
        for (int round = 0; round < 3; ++round) {
            manifolds_begun = manifolds_ended = 0;
            moving.setWorldTransform(at(0.3f, 0, 0.3f));
            scene.bullet.stepSimulation(dt, 0);
            EXPECT_GT(manifolds_begun, 0);
            EXPECT_EQ(manifolds_begun - manifolds_ended, scene.dispatcher.getNumManifolds());
            // A program may empty some; they are filled again if their pair has contacts.
            if (round > 0) {
                scene.dispatcher.clearManifold(scene.dispatcher.getManifoldByIndexInternal(0));
                scene.bullet.stepSimulation(dt, 0);
                EXPECT_EQ(manifolds_begun - manifolds_ended, scene.dispatcher.getNumManifolds());
                scene.dispatcher.clearManifold(scene.dispatcher.getManifoldByIndexInternal(0));
            }
            // Their boxes overlap, but they are apart; and further away.
            moving.setWorldTransform(round == 0 ? at(0, 0, 0.9f) : at(0, 0, 50));
            scene.bullet.stepSimulation(dt, 0);
            EXPECT_EQ(manifolds_begun, manifolds_ended) << round;
        }
    }
    gContactStartedCallback = nullptr;
    gContactEndedCallback = nullptr;
}

TEST(InstallTest, PairsOfAGhostsOwnCacheAreBullets) {
    const auto mesh = MeshShape::bvh(ring);
    btBoxShape box({1, 1, 1});
    btGhostPairCallback callback;
    btPairCachingGhostObject ghost;
    {
        StockWorld scene;
        scene.broadphase.getOverlappingPairCache()->setInternalGhostPairCallback(&callback);
        auto& installed = bullet::install(scene.bullet, scene.contacts);
        scene.add(*mesh->shape, 0, at(0, 0, 0));
        ghost.setCollisionShape(&box);
        ghost.setWorldTransform(at(0, 0, 0.5f));
        scene.bullet.addCollisionObject(&ghost, btBroadphaseProxy::CharacterFilter,
                                        btBroadphaseProxy::AllFilter);
        installed.bind(ghost, scene.contacts.add_rigid_body(scene.contacts.add_mesh("box", ring)));
        scene.bullet.stepSimulation(dt, 0);
        btHashedOverlappingPairCache& pairs = *ghost.getOverlappingPairCache();
        EXPECT_EQ(pairs.getNumOverlappingPairs(), 1);
        const std::uint32_t written = installed.reduced_contacts();
        scene.dispatcher.dispatchAllCollisionPairs(&pairs, scene.bullet.getDispatchInfo(),
                                                   &scene.dispatcher);
        EXPECT_EQ(installed.reduced_contacts(), written);
        bullet::uninstall(scene.bullet);
        scene.bullet.removeCollisionObject(&ghost);
        EXPECT_EQ(scene.dispatcher.getNumManifolds(), 0);
    }
}

/// A closed slab of squares of side 1 from (0, -3) on, whose top is at z = 0.
MeshData floor_of_squares(std::uint32_t length) {
    MeshData mesh;
    constexpr std::uint32_t width = 6;
    const auto at = [](std::uint32_t x, std::uint32_t y, std::uint32_t top) {
        return (x * (width + 1) + y) * 2 + top;
    };
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        mesh.triangles.push_back({{a, b, c}});
        mesh.triangles.push_back({{a, c, d}});
    };
    for (std::uint32_t x = 0; x <= length; ++x)
        for (std::uint32_t y = 0; y <= width; ++y)
            for (const float z : {-1.0f, 0.0f})
                mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y) - 3, z});
    for (std::uint32_t x = 0; x < length; ++x) {
        for (std::uint32_t y = 0; y < width; ++y) {
            add(at(x, y, 1), at(x + 1, y, 1), at(x + 1, y + 1, 1), at(x, y + 1, 1));
            add(at(x, y, 0), at(x, y + 1, 0), at(x + 1, y + 1, 0), at(x + 1, y, 0));
        }
        add(at(x, 0, 0), at(x + 1, 0, 0), at(x + 1, 0, 1), at(x, 0, 1));
        add(at(x, width, 0), at(x, width, 1), at(x + 1, width, 1), at(x + 1, width, 0));
    }
    for (std::uint32_t y = 0; y < width; ++y) {
        add(at(0, y, 0), at(0, y, 1), at(0, y + 1, 1), at(0, y + 1, 0));
        add(at(length, y, 0), at(length, y + 1, 0), at(length, y + 1, 1), at(length, y, 1));
    }
    return mesh;
}

TEST(InstallTest, NothingStopsWhatSlidesOverAFloor) {
    const auto floor = MeshShape::bvh(floor_of_squares(30)),
               box = MeshShape::gimpact(scenes::box({-0.5f, -0.4f, -0.3f}, {0.5f, 0.4f, 0.3f}));
    for (const bool is_fast : {false, true})
        for (int run = 0; run < 6; ++run) {
            StockWorld scene(9.81f);
            scene.contacts = World(bvh_backend(), {.margin = is_fast ? 0 : 0.04});
            bullet::install(scene.bullet, scene.contacts);
            scene.add(*floor->shape, 0, at(0, 0, 0)).setFriction(0);
            btRigidBody& slides = scene.add(*box->shape, 1,
                                            at(3, 0.13f * static_cast<btScalar>(run), 0.3f));
            slides.setFriction(0);
            slides.setLinearVelocity({10, 0, 0});
            if (is_fast) slides.setCcdMotionThreshold(0.1f);
            for (int step = 0; step < 120; ++step) scene.bullet.stepSimulation(dt, 0);
            EXPECT_GT(slides.getLinearVelocity().x(), 9.5) << run;
            EXPECT_NEAR(slides.getWorldTransform().getOrigin().z(), 0.3, 0.02) << run;
        }
}

TEST(InstallTest, TwoFastBodiesDoNotPassThroughEachOther) {
    // Further aside, the slabs turn each other over, and their centers pass by right.
    for (const float aside : {0.0f, 0.1f, 0.2f}) {
        StockWorld scene;
        const MeshData slab = scenes::box({-1, -1, -0.2f}, {1, 1, 0.2f});
        const auto left = MeshShape::gimpact(slab), right = MeshShape::gimpact(slab);
        bullet::install(scene.bullet, scene.contacts);
        btRigidBody& a = scene.add(*left->shape, 1, at(0, 0, -2));
        btRigidBody& b = scene.add(*right->shape, 1, at(aside, 0, 2));
        a.setLinearVelocity({0, 0, 120});
        b.setLinearVelocity({0, 0, -120});
        for (btRigidBody* body : {&a, &b}) body->setCcdMotionThreshold(btScalar(0.1));
        for (int step = 0; step < 5; ++step) {
            scene.bullet.stepSimulation(dt, 0);
            EXPECT_LT(a.getWorldTransform().getOrigin().z(), b.getWorldTransform().getOrigin().z());
            EXPECT_NEAR((a.getLinearVelocity() + b.getLinearVelocity()).length(), 0, 1e-2);
        }
    }
}

TEST(InstallTest, LinkedRingsAreNotPushedThroughEachOther) {
    constexpr double pi = 3.14159265358979, half_segment = pi / 30;
    constexpr double inner = 1.5, up = 0.1;  // of the ring; from a ridge to the vertex on its slope
    StockWorld scene;
    bullet::install(scene.bullet, scene.contacts);
    const auto shape = MeshShape::gimpact(scenes::torus(2, 0.5, 30, 10));
    const btQuaternion turned({0, 0, 1}, btScalar(half_segment)),
        upright({1, 0, 0}, btScalar(pi / 2));
    scene.add(*shape->shape, 1, btTransform(turned));
    btRigidBody& other = scene.add(*shape->shape, 1, btTransform(upright * turned));
    const double edge = inner * std::cos(half_segment), aside = inner * std::sin(half_segment) - up,
                 slope = std::cos(half_segment) * std::tan(pi / 10);
    bool separates = false;
    double deepest = 0;
    for (int k = -12; k <= 12; ++k) {
        const double apart = 2 * edge + up * slope + k * 1e-6;
        other.setWorldTransform(
            btTransform(upright * turned, {btScalar(apart), btScalar(aside), btScalar(-aside)}));
        scene.bullet.performDiscreteCollisionDetection();
        for (const Contact& c : scene.contacts.contacts())
            separates |= c.found == Found::separation && c.penetration_depth() > 0.5;
        for (int m = 0; m < scene.dispatcher.getNumManifolds(); ++m) {
            const btPersistentManifold& manifold = *scene.dispatcher.getManifoldByIndexInternal(m);
            for (int i = 0; i < manifold.getNumContacts(); ++i)
                deepest = std::min<double>(deepest, manifold.getContactPoint(i).getDistance());
        }
        EXPECT_GT(scene.points(), 0);
    }
    EXPECT_TRUE(separates);
    EXPECT_GT(deepest, -0.05);
}

/// A program looks at pairs, deletes a body, moves another one into contact, and goes on.
TEST(InstallTest, WhatIsDeletedAfterALookIsNotLookedAt) {
    StockWorld scene;
    bullet::install(scene.bullet, scene.contacts);
    const auto shape = MeshShape::gimpact(ring);
    btRigidBody& first = scene.add(*shape->shape, 1, at(0, 0, 0));
    btRigidBody& second = scene.add(*shape->shape, 1, at(0.3f, 0, 0.3f));
    scene.add(*shape->shape, 1, at(0, 0.2f, -0.4f));
    scene.bullet.performDiscreteCollisionDetection();
    EXPECT_GT(scene.points(), 0);
    scene.remove_rigid(2);
    second.setWorldTransform(at(9, 0, 0));
    scene.bullet.stepSimulation(dt, 0);
    EXPECT_EQ(scene.points(), 0) << "of a body that was put elsewhere after the look";
    second.setWorldTransform(first.getWorldTransform());
    second.translate({btScalar(0.3), 0, btScalar(0.3)});
    scene.bullet.stepSimulation(dt, 0);
    EXPECT_GT(scene.points(), 0);
}

/// The height of the bound mesh of an object.
double height_of(const StockWorld& scene, const bullet::Installation& installed,
                 const btCollisionObject& object) {
    Box box;
    const BodyId body = installed.body_of(object);
    for (Vec3f p : scene.contacts.mesh(scene.contacts.mesh_of(body)).positions())
        box.extend(to_double(p));
    return box.upper.z - box.lower.z;
}

TEST(InstallTest, AShapeThatTakesAnothersPlaceIsSeen) {
    StockWorld scene;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts);
    btTriangleMesh small, large;
    add_triangles(small, scenes::box({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}));
    add_triangles(large, scenes::box({-0.4, -0.4, -0.4}, {0.4, 0.4, 0.4}));
    std::optional<btGImpactMeshShape> shape;
    shape.emplace(&small);
    shape->updateBound();
    btRigidBody& body = scene.add(*shape, 1, at(0, 0, 0));
    scene.bullet.stepSimulation(dt, 0);
    EXPECT_NEAR(height_of(scene, installed, body), 0.2, 1e-6);
    shape.emplace(&large);
    shape->updateBound();
    body.setCollisionShape(&*shape);
    scene.bullet.stepSimulation(dt, 0);
    EXPECT_NEAR(height_of(scene, installed, body), 0.8, 1e-6);
    shape->setLocalScaling({2, 2, 2});
    shape->updateBound();
    scene.bullet.stepSimulation(dt, 0);
    EXPECT_NEAR(height_of(scene, installed, body), 1.6, 1e-6);
}

TEST(InstallTest, AnotherShapeOfTheSameSizeInItsPlaceIsSeen) {
    StockWorld scene;
    bullet::install(scene.bullet, scene.contacts);
    btTriangleMesh block, diamond;
    add_triangles(block, scenes::box({-1, -1, -1}, {1, 1, 1}));
    add_triangles(diamond, scenes::hard::octahedron());
    std::optional<btGImpactMeshShape> shape;
    shape.emplace(&block);
    shape->updateBound();
    btRigidBody &body = scene.add(*shape, 1, at(0, 0, 0)),
                &other = scene.add(*shape, 1, at(9, 0, 0));
    const auto ball = MeshShape::gimpact(scenes::sphere(0.2, 1));
    scene.add(*ball->shape, 1, at(0.8f, 0.8f, 0.8f));
    scene.bullet.stepSimulation(dt, 0);
    EXPECT_GT(scene.points(), 0);
    shape.emplace(&diamond);  // `other` still has a shape at this address
    shape->updateBound();
    for (btRigidBody* each : {&body, &other}) each->setCollisionShape(&*shape);
    scene.bullet.stepSimulation(dt, 0);
    EXPECT_EQ(scene.points(), 0) << "the diamond is not where the block's corner was";
}

/// How many points lie elsewhere in the frames of their manifold's bodies than in space.
int misplaced_points(StockWorld& scene) {
    int count = 0;
    for (int m = 0; m < scene.dispatcher.getNumManifolds(); ++m) {
        const btPersistentManifold& manifold = *scene.dispatcher.getManifoldByIndexInternal(m);
        for (int i = 0; i < manifold.getNumContacts(); ++i) {
            const btManifoldPoint& point = manifold.getContactPoint(i);
            const auto is_off = [](const btCollisionObject& body, const btVector3& local,
                                   const btVector3& in_space) {
                return (body.getWorldTransform() * local - in_space).length() > btScalar(1e-4);
            };
            count += is_off(*manifold.getBody0(), point.m_localPointA, point.m_positionWorldOnA) ||
                     is_off(*manifold.getBody1(), point.m_localPointB, point.m_positionWorldOnB);
        }
    }
    return count;
}

// A body that is bound anew has another number, and the pair's manifolds name the bodies in the
// order of their numbers.
TEST(InstallTest, PointsAreWhereTheyBelongWhicheverObjectIsBoundAnew) {
    test::Random random(1);
    StockWorld scene;
    bullet::install(scene.bullet, scene.contacts);
    std::vector<std::unique_ptr<MeshShape>> shapes;
    for (const double size : {0.5, 0.6, 0.7})
        shapes.push_back(MeshShape::gimpact(scenes::box({-size, -0.4, -0.3}, {size, 0.4, 0.3})));
    const auto any_shape = [&]() -> btCollisionShape& {
        return *shapes[static_cast<std::size_t>(random.integer(0, 2))]->shape;
    };
    const auto any_place = [&] {
        return at(btScalar(random.uniform(-1, 1)), btScalar(random.uniform(-1, 1)),
                  btScalar(random.uniform(-1, 1)));
    };
    int points = 0;
    for (int step = 0; step < 200; ++step) {
        if (scene.rigid.size() < 10) scene.add(any_shape(), 1, any_place());
        const auto which = static_cast<std::size_t>(
            random.integer(0, static_cast<int>(scene.rigid.size()) - 1));
        if (random.integer(0, 2) == 0)
            scene.remove_rigid(which);
        else
            scene.rigid[which]->setCollisionShape(&any_shape());
        scene.bullet.performDiscreteCollisionDetection();
        points += scene.points();
        EXPECT_EQ(misplaced_points(scene), 0) << step;
    }
    EXPECT_GT(points, 1000);
}

/// Where a ball comes to rest on a floor.
double height_on(bool mirrored, bool reversed) {
    StockWorld scene(10);
    bullet::install(scene.bullet, scene.contacts);
    MeshData floor = scenes::box({-5, -5, -1}, {5, 5, 0});
    if (reversed)
        for (Triangle& t : floor.triangles) std::swap(t.vertex[1], t.vertex[2]);
    const auto ground = MeshShape::bvh(floor);
    const auto ball = MeshShape::gimpact(scenes::sphere(0.5, 2));
    if (mirrored) ground->shape->setLocalScaling({-1, 1, 1});
    scene.add(*ground->shape, 0, at(0, 0, 0));
    btRigidBody& body = scene.add(*ball->shape, 1, at(0.1f, 0.2f, 0.6f));
    for (int i = 0; i < 120; ++i) scene.bullet.stepSimulation(dt, 0);
    return static_cast<double>(body.getWorldTransform().getOrigin().z());
}

TEST(InstallTest, AMeshThatFacesInwardIsTurned) {
    for (const bool mirrored : {false, true})
        for (const bool reversed : {false, true})
            EXPECT_NEAR(height_on(mirrored, reversed), 0.5, 0.05) << mirrored << reversed;
}

btScalar combined(const btCollisionObject* /*a*/, const btCollisionObject* /*b*/) {
    return btScalar(0.123);
}

TEST(InstallTest, TheProgramsOwnFunctionsCombineMaterials) {
    StockWorld scene;
    bullet::install(scene.bullet, scene.contacts);
    const auto shape = MeshShape::gimpact(ring);
    scene.add(*shape->shape, 1, at(0, 0, 0));
    btRigidBody& anchored = scene.add(*shape->shape, 1, at(0.3f, 0, 0.3f));
    anchored.setCollisionFlags(anchored.getCollisionFlags() |
                               btCollisionObject::CF_HAS_FRICTION_ANCHOR);
    const auto friction = std::exchange(gCalculateCombinedFrictionCallback, &combined);
    const auto restitution = std::exchange(gCalculateCombinedRestitutionCallback, &combined);
    scene.bullet.performDiscreteCollisionDetection();
    gCalculateCombinedFrictionCallback = friction;
    gCalculateCombinedRestitutionCallback = restitution;
    ASSERT_GT(scene.points(), 0);
    const btManifoldPoint& point = scene.dispatcher.getManifoldByIndexInternal(0)->getContactPoint(
        0);
    EXPECT_EQ(point.m_combinedFriction, btScalar(0.123));
    EXPECT_EQ(point.m_combinedRestitution, btScalar(0.123));
    EXPECT_NE(point.m_contactPointFlags & BT_CONTACT_FLAG_FRICTION_ANCHOR, 0);
}

TEST(InstallTest, WhatIsUnboundIsNotListedAndWhatIsFollowedIsNotShared) {
    StockWorld scene;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts);
    const auto terrain = MeshShape::bvh(scenes::grid(2, 2, 4, 4));
    const auto shape = MeshShape::gimpact(ring);
    btRigidBody& ground = scene.add(*terrain->shape, 0, at(0, 0, 0));
    btRigidBody& body = scene.add(*shape->shape, 1, at(0, 0, 0));
    btBoxShape box({1, 1, 1});
    btRigidBody& other = scene.add(box, 1, at(0, 0, 9));
    scene.bullet.stepSimulation(dt, 0);
    ASSERT_EQ(installed.left_to_bullet().size(), 1u);
    installed.unbind(ground);
    EXPECT_TRUE(installed.left_to_bullet().empty());
    EXPECT_THROW(installed.bind(other, installed.body_of(body)), InputError);
    EXPECT_TRUE(installed.body_of(body));
}

/// Cubes of two triangles a side, which stand on few points.
TEST(InstallTest, CubesStandOnEachOther) {
    for (const Vec3d offset : {Vec3d{0.1, 0, 0}, Vec3d{0.1, 0.15, 0}, Vec3d{0, 0, 0}}) {
        StockWorld scene(10);
        bullet::install(scene.bullet, scene.contacts);
        const auto floor = MeshShape::bvh(scenes::box({-50, -50, -1}, {50, 50, 0}));
        const auto cube = MeshShape::gimpact(
            scenes::box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}));
        scene.add(*floor->shape, 0, at(0, 0, 0));
        scene.add(*cube->shape, 1, at(0, 0, 0.52f));
        btRigidBody& upper = scene.add(
            *cube->shape, 1,
            at(static_cast<btScalar>(offset.x), static_cast<btScalar>(offset.y), 1.54f));
        for (int i = 0; i < 300; ++i) scene.bullet.stepSimulation(dt, 0);
        EXPECT_NEAR(static_cast<double>(upper.getWorldTransform().getOrigin().z()), 1.5, 0.06)
            << offset.x << " " << offset.y;
    }
}

TEST(InstallTest, SleepingBodiesThatAreMovedAreLookedAtWhateverElseMoves) {
    for (const bool others_move : {false, true}) {
        StockWorld scene;
        bullet::install(scene.bullet, scene.contacts);
        const auto shape = MeshShape::gimpact(ring);
        if (others_move) {
            scene.add(*shape->shape, 1, at(20, 0, 0));
            scene.add(*shape->shape, 1, at(20.3f, 0, 0.3f));
        }
        btRigidBody& first = scene.add(*shape->shape, 1, at(0, 0, 0));
        btRigidBody& second = scene.add(*shape->shape, 1, at(9, 0, 0));
        scene.bullet.stepSimulation(dt, 0);
        const auto points_of_both = [&] {
            int count = 0;
            for (int m = 0; m < scene.dispatcher.getNumManifolds(); ++m) {
                const auto& manifold = *scene.dispatcher.getManifoldByIndexInternal(m);
                if (manifold.getBody0() == &first || manifold.getBody1() == &first)
                    count += manifold.getNumContacts();
            }
            return count;
        };
        for (btRigidBody* body : {&first, &second}) body->forceActivationState(ISLAND_SLEEPING);
        second.setWorldTransform(at(0.3f, 0, 0.3f));
        scene.bullet.updateSingleAabb(&second);
        scene.bullet.performDiscreteCollisionDetection();
        EXPECT_GT(points_of_both(), 0) << others_move;
        second.setWorldTransform(at(0.3f, 0, 1.5f));
        scene.bullet.performDiscreteCollisionDetection();
        EXPECT_EQ(points_of_both(), 0) << others_move;
    }
}

TEST(InstallTest, PointsThatAProgramRemovesOrAddsConfuseNoOthers) {
    StockWorld scene(10);
    bullet::install(scene.bullet, scene.contacts);
    const auto floor = MeshShape::bvh(scenes::box({-50, -50, -1}, {50, 50, 0}));
    const auto cube = MeshShape::gimpact(scenes::box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}));
    scene.add(*floor->shape, 0, at(0, 0, 0));
    btRigidBody& body = scene.add(*cube->shape, 1, at(0, 0, 0.499f));
    body.setActivationState(DISABLE_DEACTIVATION);
    // Each corner of the cube has a name, which its point carries on.
    int names[8] = {};
    const auto name_of = [&](const btVector3& corner) {
        return &names[(corner.x() > 0) + 2 * (corner.y() > 0) + 4 * (corner.z() > 0)];
    };
    int seen = 0;
    for (int step = 0; step < 30; ++step) {
        scene.bullet.stepSimulation(dt, 0);
        for (int m = 0; m < scene.dispatcher.getNumManifolds(); ++m) {
            btPersistentManifold& manifold = *scene.dispatcher.getManifoldByIndexInternal(m);
            const bool is_first = manifold.getBody0() == &body;
            for (int k = 0; k < manifold.getNumContacts(); ++k) {
                btManifoldPoint& point = manifold.getContactPoint(k);
                const btVector3& corner = is_first ? point.m_localPointA : point.m_localPointB;
                if (std::fabs(corner.x()) < 0.4f || std::fabs(corner.y()) < 0.4f)
                    continue;  // an edge's
                void* const name = name_of(corner);
                if (point.m_userPersistentData != nullptr) {
                    EXPECT_EQ(point.m_userPersistentData, name)
                        << step << " " << corner.x() << " " << corner.y() << " " << corner.z();
                    ++seen;
                }
                point.m_userPersistentData = name;
            }
            if (step % 3 == 0 && manifold.getNumContacts() > 1) {
                manifold.getContactPoint(0).m_userPersistentData = nullptr;
                manifold.removeContactPoint(0);
            }
            if (step % 3 == 1 && manifold.getNumContacts() < MANIFOLD_CACHE_SIZE) {
                const btVector3 high(0, 0, 3);
                manifold.addManifoldPoint(btManifoldPoint(high, high, {0, 0, 1}, 1));
            }
        }
    }
    EXPECT_GT(seen, 60);
}

/// Plain collision objects are static by their flags, but their filters let them meet.
TEST(InstallTest, StaticObjectsThatMayMeetHaveContacts) {
    StockWorld scene;
    const auto shape = MeshShape::gimpact(ring);
    btCollisionObject first, second;
    for (btCollisionObject* object : {&first, &second}) {
        object->setCollisionShape(shape->shape.get());
        ASSERT_TRUE(object->isStaticObject());
        scene.bullet.addCollisionObject(object, 1, -1);
    }
    second.setWorldTransform(at(0.3f, 0, 0.3f));
    scene.bullet.performDiscreteCollisionDetection();
    EXPECT_GT(scene.points(), 0) << "Bullet's own";
    bullet::install(scene.bullet, scene.contacts);
    scene.bullet.performDiscreteCollisionDetection();
    EXPECT_GT(scene.points(), 0);
    bullet::uninstall(scene.bullet);
    for (btCollisionObject* object : {&first, &second}) scene.bullet.removeCollisionObject(object);
}

TEST(InstallTest, UnbindingLooksAtNoBodyThatWasDeleted) {
    StockWorld scene;
    bullet::Installation& installed = bullet::install(scene.bullet, scene.contacts);
    const auto shape = MeshShape::gimpact(ring);
    btRigidBody& body = scene.add(*shape->shape, 1, at(0, 0, 0));
    scene.add_soft(ring, {0.5f, 0, 0.2f});
    scene.bullet.stepSimulation(dt, 0);
    scene.remove_soft(0);
    installed.unbind(body);
    EXPECT_FALSE(installed.body_of(body));
    scene.bullet.stepSimulation(dt, 0);
}

}  // namespace
}  // namespace pierce
