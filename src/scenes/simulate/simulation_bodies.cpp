#include <algorithm>

#include "pierce/bullet/bullet_convert.hpp"
#include "scenes/named/mass_properties.hpp"
#include "scenes/simulate/simulation_state.hpp"
#include "scenes/simulate/soft_solid.hpp"

/// The bodies of a simulation: how Bullet and the worlds of contacts get them.
namespace pierce::scenes {
namespace {

constexpr btScalar friction = btScalar(0.5);
constexpr btScalar rolling_friction = btScalar(0.02);
constexpr btScalar angular_damping = btScalar(0.1);

bullet::Baseline baseline_of(Method method) {
    return method == Method::gjk_epa    ? bullet::Baseline::gjk_epa
           : method == Method::gjk_hull ? bullet::Baseline::gjk_hull
                                        : bullet::Baseline::gimpact;
}

bool is_solid(const SceneBody& body) { return !body.collision.sheet && !body.motion_of; }

}  // namespace

std::vector<Vec3f> node_positions(const btSoftBody& soft) {
    std::vector<Vec3f> positions;
    for (int n = 0; n < soft.m_nodes.size(); ++n)
        positions.push_back(bullet::from_bullet_float(soft.m_nodes[n].m_x));
    return positions;
}

SceneSetup solid_part(SceneSetup scene) {
    std::erase_if(scene.bodies, [](const SceneBody& body) { return !is_solid(body); });
    return scene;
}

/// The body of a solid in the world in which solids meet.
BodyId Simulation::State::solid_body(std::uint32_t index) const {
    if (solids == nullptr) return rays->bodies[index];
    const auto before = std::count_if(scene.bodies.begin(), scene.bodies.begin() + index, is_solid);
    return solids->bodies[static_cast<std::size_t>(before)];
}

void Simulation::State::add_bodies() {
    const std::size_t count = scene.bodies.size();
    rigid.resize(count);
    soft.resize(count);
    sheets.resize(count);
    given.resize(count);
    led.resize(count);
    torn.resize(count);
    mass.resize(count, 0);
    shapes.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        if (scene.bodies[i].motion_of)
            add_given(i);
        else if (scene.bodies[i].collision.sheet)
            add_sheet(i);
        else if (scene.bodies[i].motion == Motion::deforming)
            add_soft(i);
        else
            add_rigid(i);
    }
}

/// What changes a soft body besides forces and contacts.
void Simulation::State::add_changes(std::uint32_t index, btSoftBody& made) {
    const SceneBody& body = scene.bodies[index];
    led[index] = std::make_unique<GuidedNodes>(made, body.guides);
    if (body.tears)
        torn[index] = std::make_unique<Tearing>(made, scene.meshes[body.mesh].data, *body.tears);
}

void Simulation::State::add_rigid(std::uint32_t index) {
    const SceneBody& body = scene.bodies[index];
    const SceneMesh& mesh = scene.meshes[body.mesh];
    const bool fixed = body.motion == Motion::fixed;
    // With rays, Bullet's broad phase uses only the box of the shape.
    const bullet::Baseline kind = method == Method::rays || method == Method::bullet_clusters
                                      ? bullet::Baseline::gjk_hull
                                      : baseline_of(method);
    shapes.push_back(body.ground
                         ? bullet::BaselineShape::ground(mesh.data)
                         : bullet::BaselineShape(kind, mesh.name, mesh.data, mesh.convex_pieces,
                                                 scene.baseline_margin));

    btVector3 inertia(0, 0, 0);
    if (!fixed) {
        const MassProperties properties = mass_properties(mesh.data);
        mass[index] = properties.mass;
        inertia = bullet::to_bullet(properties.inertia);
    }
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass[index]), nullptr,
                                                  &shapes.back().shape(), inertia);
    info.m_startWorldTransform = bullet::to_bullet(body.pose);
    info.m_friction = friction;
    info.m_rollingFriction = rolling_friction;
    info.m_spinningFriction = rolling_friction;
    info.m_angularDamping = fixed ? btScalar(0) : angular_damping;
    rigid[index] = std::make_unique<btRigidBody>(info);
    rigid[index]->setUserIndex(static_cast<int>(index));
    world->addRigidBody(rigid[index].get());
    if (body.path)
        rigid[index]->setCollisionFlags(rigid[index]->getCollisionFlags() |
                                        btCollisionObject::CF_KINEMATIC_OBJECT);
    if (apart != nullptr) apart->bind(*rigid[index], rays->bodies[index]);
    if (solids != nullptr || (apart == nullptr && rays != nullptr))
        installed->bind(*rigid[index], solid_body(index));
}

void Simulation::State::add_soft(std::uint32_t index) {
    const SceneBody& body = scene.bodies[index];
    const MeshData& mesh = scene.meshes[body.mesh].data;
    soft[index] = soft_solid(world->getWorldInfo(), body, mesh);
    btSoftBody& made = *soft[index];
    mass[index] = mass_properties(mesh).mass;
    made.setUserIndex(static_cast<int>(index));
    world->addSoftBody(&made);
    add_changes(index, made);
    installed->bind(made, solid_body(index));
}

void Simulation::State::add_sheet(std::uint32_t index) {
    const SceneBody& body = scene.bodies[index];
    sheets[index] = std::make_unique<SoftSheet>(world->getWorldInfo(), body,
                                                scene.meshes[body.mesh].data);
    mass[index] = sheets[index]->mass();
    world->addSoftBody(&sheets[index]->soft());
    add_changes(index, sheets[index]->soft());
    if (apart != nullptr)
        apart->bind(sheets[index]->soft(), rays->bodies[index]);
    else
        sheets[index]->collide_by_bullet();
}

void Simulation::State::add_given(std::uint32_t index) {
    given[index].resize(scene.meshes[scene.bodies[index].mesh].data.positions.size());
    scene.bodies[index].motion_of(0, given[index]);
    rays->world.set_motion(rays->bodies[index], given[index], given[index]);
}

}  // namespace pierce::scenes
