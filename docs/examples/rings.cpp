// Two linked rings, one of which is fixed: a Bullet program with GImpact, and with Pierce's two
// lines if PIERCE is defined.
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>
#include <memory>

#ifdef PIERCE
#include <pierce/bullet/install.hpp>
#include <pierce/embree_backend.hpp>
#endif

namespace {

constexpr int around = 48, across = 16;
constexpr double pi = 3.14159265358979, ring_radius = 2, tube_radius = 0.4;

btVector3 point_of_ring(int i, int k) {
    const double u = 2 * pi * (i % around) / around, v = 2 * pi * (k % across) / across;
    const double r = ring_radius + tube_radius * std::cos(v);
    return {btScalar(r * std::cos(u)), btScalar(r * std::sin(u)),
            btScalar(tube_radius * std::sin(v))};
}

std::unique_ptr<btTriangleMesh> ring_mesh() {
    auto mesh = std::make_unique<btTriangleMesh>();
    for (int i = 0; i < around; ++i)
        for (int k = 0; k < across; ++k) {
            const btVector3 a = point_of_ring(i, k), b = point_of_ring(i + 1, k),
                            c = point_of_ring(i + 1, k + 1), d = point_of_ring(i, k + 1);
            mesh->addTriangle(a, b, c);
            mesh->addTriangle(a, c, d);
        }
    return mesh;
}

}  // namespace

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, 0, btScalar(-9.81)});

#ifdef PIERCE
    pierce::World contacts(pierce::embree_backend());
    pierce::bullet::install(world, contacts);
#endif

    const std::unique_ptr<btTriangleMesh> mesh = ring_mesh();
    btGImpactMeshShape shape(mesh.get());
    shape.setMargin(btScalar(0.01));
    shape.updateBound();
    btVector3 inertia;
    shape.calculateLocalInertia(1, inertia);
    using Construction = btRigidBody::btRigidBodyConstructionInfo;
    btRigidBody fixed(Construction(0, nullptr, &shape));
    btRigidBody hanging(Construction(1, nullptr, &shape, inertia));
    // Upright, and turned by a quarter about the vertical.
    fixed.setWorldTransform(btTransform(btQuaternion({1, 0, 0}, btScalar(pi / 2))));
    hanging.setWorldTransform(btTransform(
        btQuaternion({0, 0, 1}, btScalar(pi / 2)) * btQuaternion({1, 0, 0}, btScalar(pi / 2)),
        {0, 0, -2}));
    world.addRigidBody(&fixed);
    world.addRigidBody(&hanging);

    for (int step = 0; step < 600; ++step) world.stepSimulation(btScalar(1. / 60), 0);

    btScalar deepest = 0;
    int points = 0;
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
        points += manifold.getNumContacts();
        for (int i = 0; i < manifold.getNumContacts(); ++i)
            deepest = btMax(deepest, -manifold.getContactPoint(i).getDistance());
    }
    const btVector3 center = hanging.getWorldTransform().getOrigin();
    std::printf("hangs at %.3f, speed %.4f, %d contacts, deepest %.4f\n", double(center.z()),
                double(hanging.getLinearVelocity().length()), points, double(deepest));

#ifdef PIERCE
    pierce::bullet::uninstall(world);
#endif
    world.removeRigidBody(&hanging);
    world.removeRigidBody(&fixed);
}
