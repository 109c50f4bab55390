#include "physical/simulation.hpp"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <vector>

#include "pierce/bullet/baseline_shapes.hpp"
#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/error.hpp"
#include "scenes/named/mass_properties.hpp"

namespace pierce::physical {
namespace {

/// The coefficient of a pair, which is the product of its two bodies' coefficients in Bullet.
constexpr double pair_friction = 0.5;

/// The margin of gimpact-wide [length]: that of Bullet's convex hulls.
constexpr btScalar wide_margin = CONVEX_DISTANCE_MARGIN;

/// Bullet's world with a clock on collision detection.
class ClockedWorld : public btDiscreteDynamicsWorld {
public:
    using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

    void performDiscreteCollisionDetection() override {
        const auto begin = std::chrono::steady_clock::now();
        btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
        detection_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                                 begin)
                           .count();
    }

    double detection_ms = 0;
};

/// A mesh that does not move, as Bullet's own programs have it.
struct FixedShape {
    explicit FixedShape(const MeshData& mesh) {
        for (const Triangle& t : mesh.triangles)
            triangles.addTriangle(bullet::to_bullet(mesh.positions[t.vertex[0]]),
                                  bullet::to_bullet(mesh.positions[t.vertex[1]]),
                                  bullet::to_bullet(mesh.positions[t.vertex[2]]));
        shape = std::make_unique<btBvhTriangleMeshShape>(&triangles, true);
    }

    btTriangleMesh triangles;
    std::unique_ptr<btBvhTriangleMeshShape> shape;
};

std::unique_ptr<bullet::BaselineShape> moving_shape(const scenes::SceneMesh& mesh,
                                                    const std::string& method) {
    const bullet::Baseline kind = method.starts_with("pieces") ? bullet::Baseline::gjk_epa
                                                               : bullet::Baseline::gimpact;
    auto made = std::make_unique<bullet::BaselineShape>(kind, mesh.name, mesh.data,
                                                        mesh.convex_pieces);
    if (method.starts_with("gimpact-wide")) {
        auto& shape = static_cast<btGImpactMeshShape&>(made->shape());
        shape.setMargin(wide_margin);
        shape.updateBound();
    }
    return made;
}

}  // namespace

struct Simulation::State {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    ClockedWorld world{&dispatcher, &broadphase, &solver, &configuration};
    std::unique_ptr<World> contacts;                                    ///< Pierce's
    std::vector<std::unique_ptr<bullet::BaselineShape>> planes;         ///< by mesh
    std::vector<std::unique_ptr<FixedShape>> fixed_shapes;              ///< by mesh
    std::vector<std::unique_ptr<bullet::BaselineShape>> moving_shapes;  ///< by mesh
    std::vector<std::unique_ptr<btRigidBody>> bodies;

    void make_shapes(const Scene& scene, const std::string& method);
    btCollisionShape& shape_of(const Body& body);
    void add_body(const Scene& scene, const Body& body);
};

void Simulation::State::make_shapes(const Scene& scene, const std::string& method) {
    fixed_shapes.resize(scene.meshes.size());
    moving_shapes.resize(scene.meshes.size());
    planes.resize(scene.meshes.size());
    for (std::uint32_t m = 0; m < scene.meshes.size(); ++m) {
        const scenes::SceneMesh& mesh = scene.meshes[m];
        if (std::ranges::any_of(scene.bodies,
                                [m](const Body& b) { return b.mesh == m && !b.fixed; }))
            moving_shapes[m] = moving_shape(mesh, method);
        else if (method.ends_with("-plane"))
            planes[m] = std::make_unique<bullet::BaselineShape>(
                bullet::BaselineShape::ground(mesh.data));
        else
            fixed_shapes[m] = std::make_unique<FixedShape>(mesh.data);
    }
}

btCollisionShape& Simulation::State::shape_of(const Body& body) {
    if (moving_shapes[body.mesh]) return moving_shapes[body.mesh]->shape();
    if (planes[body.mesh]) return planes[body.mesh]->shape();
    return *fixed_shapes[body.mesh]->shape;
}

void Simulation::State::add_body(const Scene& scene, const Body& body) {
    double mass = 0;
    btVector3 inertia(0, 0, 0);
    if (!body.fixed) {
        const auto properties = scenes::mass_properties(scene.meshes[body.mesh].data);
        mass = properties.mass;
        inertia = bullet::to_bullet(properties.inertia);
    }
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr,
                                                  &shape_of(body), inertia);
    info.m_startWorldTransform = bullet::to_bullet(body.pose);
    info.m_friction = static_cast<btScalar>(std::sqrt(pair_friction));
    btRigidBody& made = *bodies.emplace_back(std::make_unique<btRigidBody>(info));
    made.setLinearVelocity(bullet::to_bullet(body.velocity));
    made.setAngularVelocity(bullet::to_bullet(body.angular_velocity));
    if (!scene.may_sleep) made.setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(&made);
}

std::span<const std::string> method_names() {
    static const std::array<std::string, 9> names = {
        "pierce",       "pierce-complete",    "pierce-margin", "gimpact",     "gimpact-plane",
        "gimpact-wide", "gimpact-wide-plane", "pieces",        "pieces-plane"};
    return names;
}

Simulation::Simulation(const Scene& scene, const MethodSettings& settings)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    if (std::ranges::count(method_names(), settings.method) == 0)
        throw InputError("unknown method '" + settings.method + "'");
    s.world.setGravity({0, 0, static_cast<btScalar>(-scene.gravity)});
    if (settings.method.starts_with("gimpact"))
        btGImpactCollisionAlgorithm::registerAlgorithm(&s.dispatcher);
    s.make_shapes(scene, settings.method);
    for (const Body& body : scene.bodies) s.add_body(scene, body);
    if (!settings.method.starts_with("pierce")) return;
    Settings world;
    if (settings.method != "pierce") world.coverage = Coverage::complete;
    if (settings.method == "pierce-margin") world.margin = settings.margin;
    s.contacts = std::make_unique<World>(embree_backend(1), world);
    bullet::install(s.world, *s.contacts, {.most_per_pair = settings.most_per_pair});
}

Simulation::~Simulation() {
    bullet::uninstall(state_->world);
    for (const auto& body : state_->bodies) state_->world.removeRigidBody(body.get());
}

void Simulation::step(double dt) { state_->world.stepSimulation(static_cast<btScalar>(dt), 0); }

BodyState Simulation::state_of(std::size_t body) const {
    const btRigidBody& b = *state_->bodies[body];
    return {bullet::from_bullet(b.getWorldTransform()), bullet::from_bullet(b.getLinearVelocity()),
            bullet::from_bullet(b.getAngularVelocity())};
}

bool Simulation::all_sleep() const {
    return std::ranges::none_of(state_->bodies, [](const auto& body) {
        return !body->isStaticObject() && body->isActive();
    });
}

double Simulation::detection_milliseconds() const { return state_->world.detection_ms; }

double Simulation::deepest_point() const {
    double deepest = 0;
    for (int m = 0; m < state_->dispatcher.getNumManifolds(); ++m) {
        const auto& manifold = *state_->dispatcher.getManifoldByIndexInternal(m);
        for (int i = 0; i < manifold.getNumContacts(); ++i)
            deepest = std::min<double>(deepest, manifold.getContactPoint(i).getDistance());
    }
    return deepest;
}

std::uint32_t Simulation::points() const {
    int count = 0;
    for (int m = 0; m < state_->dispatcher.getNumManifolds(); ++m)
        count += state_->dispatcher.getManifoldByIndexInternal(m)->getNumContacts();
    return static_cast<std::uint32_t>(count);
}

}  // namespace pierce::physical
