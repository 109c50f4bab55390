#include "scenes/simulate/simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "pierce/bullet/bullet_convert.hpp"
#include "pierce/error.hpp"
#include "scenes/named/mass_properties.hpp"
#include "scenes/simulate/sheet_crossings.hpp"
#include "scenes/simulate/simulation_state.hpp"
#include "scenes/simulate/soft_damping.hpp"

namespace pierce::scenes {
namespace {

/// The part of the vibration of soft bodies that a step takes away.
constexpr btScalar vibration_damping = btScalar(0.5);

}  // namespace

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
        if (led[i]) led[i]->lead(time + dt, dt);
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
            mesh_of(static_cast<std::uint32_t>(i)).triangles, positions);
        result.self_crossings += found.count;
        result.self_penetration = std::max(result.self_penetration, found.depth);
    }
}

const MeshData& Simulation::State::mesh_of(std::uint32_t index) const {
    return torn[index] ? torn[index]->mesh() : scene.meshes[scene.bodies[index].mesh].data;
}

/// Puts solids that deform, which sheets do not move, where Bullet's step has moved them.
void Simulation::State::move_soft_obstacles() {
    for (std::uint32_t i = 0; i < soft.size(); ++i)
        if (soft[i]) rays->world.set_positions(rays->bodies[i], node_positions(*soft[i]));
}

/// Tears what is stretched too far, and gives the worlds of contacts the torn meshes.
std::uint32_t Simulation::State::tear() {
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < torn.size(); ++i) {
        const std::uint32_t tears = torn[i] ? torn[i]->tear() : 0;
        if (tears == 0) continue;
        count += tears;
        const SceneMesh& before = scene.meshes[scene.bodies[i].mesh];
        const SceneMesh mesh{.name = before.name + " torn",
                             .data = mesh_of(i),
                             .convex_pieces = {},
                             .inside = before.inside};
        btSoftBody& body = *soft_body(i);
        const std::vector<Vec3f> positions = node_positions(body);
        rays->set_mesh(i, mesh, positions);
        if (sheets[i]) {
            apart->bind(body, rays->bodies[i]);
            continue;
        }
        if (solids != nullptr) solids->set_mesh(solid_body(i).index, mesh, positions);
        installed->bind(body, solid_body(i));
    }
    return count;
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
        any_soft_solid |= body.motion == Motion::deforming && !body.collision.sheet &&
                          !body.motion_of;
    }
    if (method != Method::rays && std::ranges::any_of(scene.bodies, [](const SceneBody& body) {
            return body.tears.has_value();
        }))
        throw InputError("bodies tear with rays only");
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
        s.dispatcher = std::make_unique<btCollisionDispatcher>(configuration);
        if (any_sheet && (any_free || any_soft_solid))
            s.solids = std::make_unique<SceneWorld>(solid_part(scene), settings);
        if (any_sheet) s.apart = std::make_unique<bullet::SheetResponse>(s.rays->world);
    } else {
        if (by_clusters) configuration = &s.soft_configuration;
        s.dispatcher = std::make_unique<TimedDispatcher>(configuration);
        register_baseline(*s.dispatcher);
    }
    s.world = std::make_unique<ClockedWorld>(
        s.dispatcher.get(), &s.broadphase, &s.solver, configuration,
        any_sheet && !any_soft_solid ? nullptr : &s.soft_solver);
    if (s.solids != nullptr || (s.rays != nullptr && !any_sheet && !any_given))
        s.installed = &bullet::install(*s.world, s.solids ? s.solids->world : s.rays->world,
                                       {.automatic = false});
    const btVector3 down(0, 0, static_cast<btScalar>(-scene.gravity));
    s.world->setGravity(down);
    s.world->getWorldInfo().m_gravity = down;

    s.add_bodies();
}

Simulation::~Simulation() {
    bullet::uninstall(*state_->world);
    for (std::size_t i = 0; i < state_->soft.size(); ++i)
        if (btSoftBody* body = state_->soft_body(i)) state_->world->removeSoftBody(body);
    for (const auto& body : state_->rigid)
        if (body) state_->world->removeRigidBody(body.get());
}

const FrameResult& Simulation::step(double dt) {
    check_time_step(dt, "time step");
    State& s = *state_;
    s.rigid_configuration.take_epa_milliseconds();
    const std::uint32_t tears = s.tear();
    s.lead(dt);
    s.world->stepSimulation(static_cast<btScalar>(dt), 0);
    s.time += dt;
    for (std::size_t i = 0; i < s.soft.size(); ++i)
        // The parts of a torn body move each for itself.
        if (s.soft[i] && !s.torn[i]) damp_vibration(*s.soft[i], vibration_damping);
    if (s.apart != nullptr) {
        s.note_tried();
        s.move_soft_obstacles();
        const bullet::SheetReport& report = s.apart->finish_step(dt);
        s.result = sheet_result(s.rays->result(), report);
        if (s.solids != nullptr) {
            const double ms = s.solids->world.stats().milliseconds;
            s.result.times.push_back({"solids", ms});
            s.result.total_ms += ms;
        }
        s.measure_sheets();
    } else if (s.installed == nullptr && s.rays != nullptr) {
        s.rays->world.detect();
        s.result = s.rays->result();
    } else if (s.rays != nullptr) {
        s.result = s.rays->result();
        if (!s.installed->has_detected()) s.result.forget_times();
        s.result.response_ms = s.installed->response_milliseconds();
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
    s.result.tears = tears;
    return s.result;
}

namespace {

void add_pose(std::vector<float>& values, const Pose& pose) {
    for (double v : {pose.position.x, pose.position.y, pose.position.z, pose.rotation.x,
                     pose.rotation.y, pose.rotation.z, pose.rotation.w})
        values.push_back(static_cast<float>(v));
}

}  // namespace

void Simulation::State::record(Recording& recording, bool as_tried) const {
    for (std::uint32_t i = 0; i < recording.bodies.size(); ++i) {
        std::vector<float>& values = recording.bodies[i].values;
        const auto add = [&](std::span<const Vec3f> positions) {
            for (Vec3f p : positions) values.insert(values.end(), {p.x, p.y, p.z});
        };
        if (as_tried && sheets[i] && !tried.empty()) {
            add(tried[i]);
        } else if (const btSoftBody* made = soft_body(i)) {
            if (torn[i]) record_mesh(recording, i);
            add(node_positions(*made));
        } else if (!given[i].empty()) {
            add(given[i]);
        } else {
            add_pose(values, bullet::from_bullet(rigid[i]->getWorldTransform()));
        }
    }
    ++recording.frame_count;
}

/// Adds the bodies where the last step has looked for contacts of solids.
void Simulation::State::record_seen(Recording& recording) const {
    for (std::uint32_t i = 0; i < recording.bodies.size(); ++i) {
        std::vector<float>& values = recording.bodies[i].values;
        const BodyId body = rays->bodies[i];
        if (rays->world.motion_of(body) != Motion::deforming) {
            add_pose(values, rays->world.pose_of(body));
            continue;
        }
        for (const Vec3d p : rays->world.vertex_positions(body)) {
            const Vec3f place = to_float(p);
            values.insert(values.end(), {place.x, place.y, place.z});
        }
    }
    ++recording.frame_count;
}

/// Notes a body's mesh if the recording has had another one of it so far.
void Simulation::State::record_mesh(Recording& recording, std::uint32_t index) const {
    RecordedBody& body = recording.bodies[index];
    const MeshData& mesh = torn[index]->mesh();
    const std::uint32_t last = recording.mesh_of(index, recording.frame_count);
    // Every tear adds vertices.
    if (recording.meshes[last].data.positions.size() == mesh.positions.size()) return;
    const auto number = static_cast<std::uint32_t>(recording.meshes.size());
    const SceneMesh& first = recording.meshes[body.mesh];
    const std::string name = body.name + " from frame " + std::to_string(recording.frame_count);
    recording.meshes.push_back(
        {.name = name, .data = mesh, .convex_pieces = {}, .inside = first.inside});
    if (recording.frame_count == 0)
        body.mesh = number;
    else
        body.mesh_changes.push_back({recording.frame_count, number});
}

const FrameResult& Simulation::step(double dt, Recording& recording) {
    const State& s = *state_;
    if (s.rays == nullptr) record(recording);
    step(dt);
    // Bullet moves nodes of solids ahead before it looks for their contacts.
    if (s.rays != nullptr && s.installed != nullptr && s.apart == nullptr)
        s.record_seen(recording);
    else if (s.rays != nullptr)
        record(recording);
    return s.result;
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
