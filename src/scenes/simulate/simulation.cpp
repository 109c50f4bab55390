#include "scenes/simulate/simulation.hpp"

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "pierce/bullet/baseline_shapes.hpp"
#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/bullet/bullet_dispatcher.hpp"
#include "pierce/bullet/sheet_response.hpp"
#include "pierce/bullet/soft_solver.hpp"
#include "pierce/error.hpp"
#include "scenes/detect/bullet_result.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/detect/soft_sheet.hpp"
#include "scenes/named/mass_properties.hpp"
#include "scenes/simulate/sheet_crossings.hpp"
#include "scenes/simulate/soft_damping.hpp"
#include "scenes/simulate/soft_solid.hpp"

namespace pierce::scenes {
namespace {

/// The part of the vibration of soft bodies that a step takes away.
constexpr btScalar vibration_damping = btScalar(0.5);
constexpr btScalar friction = btScalar(0.5);
constexpr btScalar rolling_friction = btScalar(0.02);
constexpr btScalar angular_damping = btScalar(0.1);

/// Bullet's world with a clock on collision detection.
class ClockedWorld : public btSoftRigidDynamicsWorld {
public:
    using btSoftRigidDynamicsWorld::btSoftRigidDynamicsWorld;

    void performDiscreteCollisionDetection() override {
        const auto begin = std::chrono::steady_clock::now();
        btSoftRigidDynamicsWorld::performDiscreteCollisionDetection();
        detection_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                                 begin)
                           .count();
    }

    double detection_ms = 0;
};

std::vector<Vec3f> node_positions(const btSoftBody& soft) {
    std::vector<Vec3f> positions;
    for (int n = 0; n < soft.m_nodes.size(); ++n)
        positions.push_back(bullet::from_bullet_float(soft.m_nodes[n].m_x));
    return positions;
}

bullet::Baseline baseline_of(Method method) {
    return method == Method::gjk_epa    ? bullet::Baseline::gjk_epa
           : method == Method::gjk_hull ? bullet::Baseline::gjk_hull
                                        : bullet::Baseline::gimpact;
}

/// The scene without its sheets.
SceneSetup rigid_part(SceneSetup scene) {
    std::erase_if(scene.bodies,
                  [](const SceneBody& body) { return body.motion == Motion::deforming; });
    return scene;
}

}  // namespace

struct Simulation::State {
    SceneSetup scene;
    Method method;
    std::unique_ptr<SceneWorld> rays;    ///< null for Bullet's own methods
    std::unique_ptr<SceneWorld> solids;  ///< the rigid bodies alone; set where there are sheets and
                                         ///< rigid bodies that move
    bullet::TimedConfiguration rigid_configuration;
    btSoftBodyRigidBodyCollisionConfiguration soft_configuration;
    std::unique_ptr<btCollisionDispatcher> dispatcher;
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    std::vector<bullet::BaselineShape> shapes;
    std::vector<std::unique_ptr<btRigidBody>> rigid;  ///< by body, null if soft
    std::vector<std::unique_ptr<btSoftBody>> soft;    ///< by body, null unless it is a solid that
                                                      ///< deforms
    std::vector<std::unique_ptr<SoftSheet>> sheets;   ///< by body, null if it is no sheet
    std::vector<std::vector<Vec3f>> given;            ///< by body, empty unless its motion is given
    std::unique_ptr<bullet::SheetResponse> apart;     ///< null if there are no sheets
    std::vector<std::vector<Vec3f>> tried;            ///< by body: where Bullet has put a sheet
    double time = 0;                                  ///< [s] since the start
    std::vector<double> mass;                         ///< by body
    bullet::SoftSolver soft_solver;
    std::unique_ptr<ClockedWorld> world;
    FrameResult result;

    State(const SceneSetup& s, Method m) : scene(s), method(m) {}

    bullet::Dispatcher& ray_dispatcher() { return static_cast<bullet::Dispatcher&>(*dispatcher); }
    void add_rigid(std::uint32_t index);
    void add_soft(std::uint32_t index);
    void add_sheet(std::uint32_t index);
    void add_given(std::uint32_t index);
    void lead(double dt);
    void measure_sheets();
    void note_tried();
    void record(Recording& recording, bool as_tried) const;
    btSoftBody* soft_body(std::size_t index) const {
        return soft[index] ? soft[index].get() : sheets[index] ? &sheets[index]->soft() : nullptr;
    }
};

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
    if (solids != nullptr) {
        const auto before = std::count_if(rigid.begin(), rigid.begin() + index,
                                          [](const auto& r) { return r != nullptr; });
        ray_dispatcher().bind(*rigid[index], solids->bodies[static_cast<std::size_t>(before)]);
    }
    if (apart == nullptr && rays != nullptr)
        ray_dispatcher().bind(*rigid[index], rays->bodies[index]);
}

void Simulation::State::add_sheet(std::uint32_t index) {
    const SceneBody& body = scene.bodies[index];
    sheets[index] = std::make_unique<SoftSheet>(world->getWorldInfo(), body,
                                                scene.meshes[body.mesh].data);
    mass[index] = sheets[index]->mass();
    world->addSoftBody(&sheets[index]->soft());
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

/// Moves all that is led to its place at the end of the step.
void Simulation::State::lead(double dt) {
    for (std::uint32_t i = 0; i < scene.bodies.size(); ++i) {
        const SceneBody& body = scene.bodies[i];
        if (body.path) {
            const btVector3 from = rigid[i]->getWorldTransform().getOrigin();
            rigid[i]->setWorldTransform(bullet::to_bullet(body.path(time + dt)));
            rigid[i]->setLinearVelocity((rigid[i]->getWorldTransform().getOrigin() - from) /
                                        static_cast<btScalar>(dt));
        }
        if (sheets[i]) sheets[i]->lead(time + dt, dt);
        if (body.motion_of) {
            body.motion_of(time + dt, given[i]);
            rays->world.set_positions(rays->bodies[i], given[i]);
        }
    }
}

void Simulation::State::note_tried() {
    tried.resize(sheets.size());
    for (std::size_t i = 0; i < sheets.size(); ++i)
        if (sheets[i]) tried[i] = node_positions(sheets[i]->soft());
}

/// Measures how the simulated sheets run through themselves.
void Simulation::State::measure_sheets() {
    for (std::size_t i = 0; i < sheets.size(); ++i) {
        if (!sheets[i]) continue;
        const std::vector<Vec3f> positions = node_positions(sheets[i]->soft());
        const SurfaceCrossings found = self_crossings(
            scene.meshes[scene.bodies[i].mesh].data.triangles, positions);
        result.self_crossings += found.count;
        result.self_penetration = std::max(result.self_penetration, found.depth);
    }
}

void Simulation::State::add_soft(std::uint32_t index) {
    const SceneBody& body = scene.bodies[index];
    const MeshData& mesh = scene.meshes[body.mesh].data;
    soft[index] = soft_solid(world->getWorldInfo(), body, mesh);
    btSoftBody& made = *soft[index];
    mass[index] = mass_properties(mesh).mass;
    made.setUserIndex(static_cast<int>(index));
    world->addSoftBody(&made);
    ray_dispatcher().bind(made, rays->bodies[index]);
}

Simulation::Simulation(const SceneSetup& scene, Method method, const RaySettings& settings)
    : state_(std::make_unique<State>(scene, method)) {
    State& s = *state_;
    bool any_soft = false, any_sheet = false, any_given = false, any_free = false,
         any_soft_solid = false;
    for (const SceneBody& body : scene.bodies) {
        any_soft |= body.motion == Motion::deforming;
        any_given |= body.motion_of != nullptr;
        any_sheet |= body.collision.sheet && !body.motion_of;
        any_free |= body.motion == Motion::rigid;
        any_soft_solid |= body.motion == Motion::deforming && !body.collision.sheet;
    }
    if (any_sheet && any_soft_solid)
        throw InputError("sheets are not simulated with solids that deform");
    const bool by_clusters = method == Method::bullet_clusters;
    if (any_soft && method != Method::rays && !(by_clusters && any_sheet))
        throw InputError(
            "soft bodies are simulated with rays only, sheets also with bullet-clusters");
    if (by_clusters && !any_sheet) throw InputError("bullet-clusters is for sheets");
    if (method == Method::fcl) throw InputError("fcl detects contacts; it does not simulate");

    btCollisionConfiguration* configuration = &s.rigid_configuration;
    if (method == Method::rays) {
        s.rays = std::make_unique<SceneWorld>(scene, settings);
        configuration = &s.soft_configuration;
        if (any_sheet && any_free) {
            s.solids = std::make_unique<SceneWorld>(rigid_part(scene), settings);
            s.dispatcher = std::make_unique<bullet::Dispatcher>(configuration, s.solids->world);
        } else if (any_sheet || any_given)
            s.dispatcher = std::make_unique<btCollisionDispatcher>(configuration);
        else
            s.dispatcher = std::make_unique<bullet::Dispatcher>(configuration, s.rays->world);
        if (any_sheet) s.apart = std::make_unique<bullet::SheetResponse>(s.rays->world);
    } else {
        if (by_clusters) configuration = &s.soft_configuration;
        s.dispatcher = std::make_unique<TimedDispatcher>(configuration);
        register_baseline(*s.dispatcher);
    }
    s.world = std::make_unique<ClockedWorld>(s.dispatcher.get(), &s.broadphase, &s.solver,
                                             configuration, any_sheet ? nullptr : &s.soft_solver);
    const btVector3 down(0, 0, static_cast<btScalar>(-scene.gravity));
    s.world->setGravity(down);
    s.world->getWorldInfo().m_gravity = down;

    const std::size_t count = scene.bodies.size();
    s.rigid.resize(count);
    s.soft.resize(count);
    s.sheets.resize(count);
    s.given.resize(count);
    s.mass.resize(count, 0);
    s.shapes.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        if (scene.bodies[i].motion_of)
            s.add_given(i);
        else if (scene.bodies[i].collision.sheet)
            s.add_sheet(i);
        else if (scene.bodies[i].motion == Motion::deforming)
            s.add_soft(i);
        else
            s.add_rigid(i);
    }
}

Simulation::~Simulation() {
    for (std::size_t i = 0; i < state_->soft.size(); ++i)
        if (btSoftBody* body = state_->soft_body(i)) state_->world->removeSoftBody(body);
    for (const auto& body : state_->rigid)
        if (body) state_->world->removeRigidBody(body.get());
}

const FrameResult& Simulation::step(double dt) {
    if (!(dt > 0) || !std::isfinite(dt)) throw InputError("time step must be positive");
    State& s = *state_;
    s.rigid_configuration.take_epa_milliseconds();
    s.lead(dt);
    s.world->stepSimulation(static_cast<btScalar>(dt), 0);
    s.time += dt;
    for (const auto& body : s.soft)
        if (body) damp_vibration(*body, vibration_damping);
    if (s.apart != nullptr) {
        s.note_tried();
        const bullet::SheetReport& report = s.apart->finish_step(dt);
        s.result = sheet_result(s.rays->result(), report);
        if (s.solids != nullptr) {
            const double ms = s.solids->world.stats().milliseconds;
            s.result.times.push_back({"solids", ms});
            s.result.total_ms += ms;
        }
        s.measure_sheets();
    } else if (dynamic_cast<bullet::Dispatcher*>(s.dispatcher.get()) == nullptr &&
               s.rays != nullptr) {
        s.rays->world.detect();
        s.result = s.rays->result();
    } else if (s.rays != nullptr) {
        s.result = s.rays->result();
        s.result.response_ms = s.ray_dispatcher().response_milliseconds();
        s.result.times.push_back({"response", s.result.response_ms});
        s.result.total_ms += s.result.response_ms;
    } else {
        // Bullet keeps its bodies a margin apart, so in its own simulation they touch where their
        // margins do.
        s.result = bullet_result(static_cast<TimedDispatcher&>(*s.dispatcher), s.shapes,
                                 Margin::counts, s.world->detection_ms, 0,
                                 s.rigid_configuration.take_epa_milliseconds());
        const auto begin = std::chrono::steady_clock::now();
        for (const auto& sheet : s.sheets) {
            if (!sheet) continue;
            sheet->meet_itself();
            s.result.contacts += static_cast<std::uint32_t>(sheet->soft().m_joints.size());
        }
        if (s.method == Method::bullet_clusters) {
            const std::chrono::duration<double, std::milli>
                taken = std::chrono::steady_clock::now() - begin;
            s.result.times.push_back({"clusters", taken.count()});
            s.result.total_ms += taken.count();
        }
        s.measure_sheets();
    }
    return s.result;
}

void Simulation::State::record(Recording& recording, bool as_tried) const {
    for (std::uint32_t i = 0; i < recording.bodies.size(); ++i) {
        std::vector<float>& values = recording.bodies[i].values;
        const auto add = [&](std::span<const Vec3f> positions) {
            for (Vec3f p : positions) values.insert(values.end(), {p.x, p.y, p.z});
        };
        if (as_tried && sheets[i] && !tried.empty()) {
            add(tried[i]);
        } else if (const btSoftBody* made = soft_body(i)) {
            add(node_positions(*made));
        } else if (!given[i].empty()) {
            add(given[i]);
        } else {
            const Pose pose = bullet::from_bullet(rigid[i]->getWorldTransform());
            for (double v : {pose.position.x, pose.position.y, pose.position.z, pose.rotation.x,
                             pose.rotation.y, pose.rotation.z, pose.rotation.w})
                values.push_back(static_cast<float>(v));
        }
    }
    ++recording.frame_count;
}

void Simulation::record(Recording& recording) const { state_->record(recording, false); }

void Simulation::record_tried(Recording& recording) const { state_->record(recording, true); }

double Simulation::kinetic_energy_per_mass() const {
    const State& s = *state_;
    double energy = 0, mass = 0;
    for (std::size_t i = 0; i < s.mass.size(); ++i) {
        mass += s.mass[i];
        if (s.rigid[i] && s.mass[i] > 0)
            energy += 0.5 * s.mass[i] * s.rigid[i]->getLinearVelocity().length2();
        if (const btSoftBody* soft = s.soft_body(i))
            for (int n = 0; n < soft->m_nodes.size(); ++n)
                energy += 0.5 * s.mass[i] / soft->m_nodes.size() * soft->m_nodes[n].m_v.length2();
    }
    return mass > 0 ? energy / mass : 0;
}

Vec3d Simulation::vertex_position(std::uint32_t body, std::uint32_t vertex) const {
    const State& s = *state_;
    if (const btSoftBody* soft = s.soft_body(body))
        return bullet::from_bullet(soft->m_nodes[static_cast<int>(vertex)].m_x);
    if (!s.given[body].empty()) return to_double(s.given[body][vertex]);
    const Vec3f rest = s.scene.meshes[s.scene.bodies[body].mesh].data.positions[vertex];
    return frame_of(bullet::from_bullet(s.rigid[body]->getWorldTransform()))
        .to_parent(to_double(rest));
}

double Simulation::volume_ratio(std::uint32_t body) const {
    const MeshData& mesh = state_->scene.meshes[state_->scene.bodies[body].mesh].data;
    return volume_of(mesh, [&](std::uint32_t v) { return vertex_position(body, v); }) /
           volume_of(mesh, [&](std::uint32_t v) { return to_double(mesh.positions[v]); });
}

World* Simulation::world() { return state_->rays ? &state_->rays->world : nullptr; }

}  // namespace pierce::scenes
