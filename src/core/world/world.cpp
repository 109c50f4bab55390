#include "pierce/world.hpp"

#include <chrono>
#include <cmath>
#include <utility>

#include "core/base/usable.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/mesh/patch.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/world/world_state.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"

namespace pierce {

namespace {

void check_pose(const Pose& pose, const std::string& mesh) {
    if (!is_usable(pose))
        throw InputError("pose of a body of mesh '" + mesh +
                         "' is not finite, too far away or has no rotation");
}

}  // namespace

World::World(const Settings& settings) : World(reference_backend(), settings) {}

World::World(std::unique_ptr<Backend> backend, const Settings& settings)
    : state_(std::make_unique<State>()) {
    if (backend == nullptr) throw InputError("a world needs a backend");
    if (settings.coverage > Coverage::overlaps || settings.temporal > Temporal::certified)
        throw InputError("coverage or temporal has a value without a meaning");
    if (!(settings.open_body_range > 0)) throw InputError("open_body_range must be positive");
    if (!(settings.margin >= 0) || settings.margin > constants::largest_coordinate)
        throw InputError("margin must be neither negative nor beyond 2^60");
    if (settings.full_every == 0) throw InputError("full_every must be at least 1");
    if (!(settings.walk_threshold >= 0)) throw InputError("walk_threshold must not be negative");
    if (std::isnan(settings.prediction_distance))
        throw InputError("prediction_distance must be a number");
    state_->backend = std::move(backend);
    state_->settings = settings;
}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

MeshId World::add_mesh(std::string name, MeshData data, MeshOptions options) {
    return add_mesh(
        std::make_shared<const Mesh>(std::move(name), std::move(data), std::move(options)));
}

MeshId World::add_mesh(std::string name, MeshData data, MeshId before, MeshOptions options) {
    return add_mesh(std::make_shared<const Mesh>(std::move(name), std::move(data),
                                                 this->mesh(before), std::move(options)));
}

MeshId World::add_mesh(std::shared_ptr<const Mesh> mesh) {
    if (!mesh) throw InputError("there is no mesh to add");
    return state_->meshes.add({std::move(mesh), state_->next_key++});
}

void World::remove_mesh(MeshId mesh) {
    const Mesh& named = this->mesh(mesh);
    for (const auto& slot : state_->bodies.slots())
        if (slot.used && slot.thing.mesh == mesh)
            throw InputError("mesh '" + named.name() + "' is still used by a body");
    state_->meshes.remove(mesh, "mesh");
}

const Mesh& World::mesh(MeshId mesh) const { return *state_->meshes.get(mesh, "mesh").mesh; }

std::shared_ptr<const Mesh> World::share_mesh(MeshId mesh) const {
    return state_->meshes.get(mesh, "mesh").mesh;
}

BodyId World::add_fixed_body(MeshId mesh, const Pose& pose) {
    check_pose(pose, this->mesh(mesh).name());
    return state_->add({mesh, Motion::fixed, pose});
}

BodyId World::add_rigid_body(MeshId mesh, const Pose& pose) {
    check_pose(pose, this->mesh(mesh).name());
    return state_->add({mesh, Motion::rigid, pose});
}

BodyId World::add_deforming_body(MeshId mesh, std::span<const Vec3f> positions) {
    const Mesh& shape = this->mesh(mesh);
    if (positions.empty()) positions = shape.positions();
    check_count(positions.size(), shape);
    check_positions("body of mesh '" + shape.name() + "'", positions);
    BodyEntry body(mesh, Motion::deforming, {});
    body.positions.assign(positions.begin(), positions.end());
    body.positions_version = state_->next_key++;
    return state_->add(std::move(body));
}

void World::remove_body(BodyId body) {
    state_->bodies.get(body, "body");
    state_->change();
    state_->bodies.remove(body, "body");
}

MeshId World::mesh_of(BodyId body) const { return state_->bodies.get(body, "body").mesh; }

Motion World::motion_of(BodyId body) const { return state_->bodies.get(body, "body").motion; }

Vec3d World::vertex_position(BodyId body, std::uint32_t vertex) const {
    const BodyEntry& entry = state_->placed_body(body);
    const Mesh& mesh = state_->mesh_of(entry);
    if (vertex >= mesh.positions().size())
        throw InputError("mesh '" + mesh.name() + "' has no vertex " + std::to_string(vertex));
    if (entry.motion == Motion::deforming) return to_double(entry.positions[vertex]);
    return frame_of(entry.pose).to_parent(to_double(mesh.positions()[vertex]));
}

std::vector<Vec3d> World::vertex_positions(BodyId body) const {
    const BodyEntry& entry = state_->placed_body(body);
    const bool deforms = entry.motion == Motion::deforming;
    const std::span<const Vec3f> local = deforms ? std::span<const Vec3f>(entry.positions)
                                                 : state_->mesh_of(entry).positions();
    const Frame frame = frame_of(entry.pose);
    std::vector<Vec3d> result;
    result.reserve(local.size());
    for (Vec3f p : local) result.push_back(deforms ? to_double(p) : frame.to_parent(to_double(p)));
    return result;
}

Pose World::pose_of(BodyId body) const {
    state_->check_have_poses({&body, 1});
    return state_->placed_body(body).pose;
}

void World::set_collision(BodyId body, const Collision& collision) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    state_->check_collision(
        entry.motion, state_->mesh_of(entry), collision,
        "body " + std::to_string(body.index) + " of mesh '" + state_->mesh_of(entry).name() + "'");
    state_->change();
    entry.collision = collision;
}

const Collision& World::collision_of(BodyId body) const {
    return state_->bodies.get(body, "body").collision;
}

void World::set_mesh(BodyId body, MeshId mesh, std::span<const Vec3f> positions) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    const Mesh& shape = this->mesh(mesh);
    if (entry.motion != Motion::deforming)
        throw InputError("body " + std::to_string(body.index) +
                         " does not deform: its mesh is set without positions");
    check_count(positions.size(), shape);
    state_->check_collision(entry.motion, shape, entry.collision,
                            "body " + std::to_string(body.index));
    // Without memory for these, nothing changes.
    std::vector<Vec3f> start(positions.begin(), positions.end()), end = start;
    state_->change_mesh(body);
    entry.mesh = mesh;
    // The next step compares with the last shape, vertex by vertex, if both have as many patches.
    if (entry.seen.size() != patch_count(shape.view({}))) entry.seen.clear();
    entry.start = std::move(start);
    entry.positions = std::move(end);
    entry.leave_device();
    entry.positions_version = state_->next_key++;
    entry.usable = is_usable(positions);
}

void World::set_mesh(BodyId body, MeshId mesh) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    state_->meshes.get(mesh, "mesh");
    if (entry.motion == Motion::deforming)
        throw InputError("body " + std::to_string(body.index) + " deforms: a mesh needs positions");
    state_->change_mesh(body);
    entry.mesh = mesh;
}

void World::forget_sides() { state_->forgets_sides = true; }

Scene World::State::scene(bool rests, const std::uint32_t& forgets) {
    return {.bodies = view_of(views),
            .ids = view_of(std::as_const(ids)),
            .changed = view_of(std::as_const(refreshed)),
            .excluded = view_of(std::as_const(excluded_pairs)),
            .pair_filter = asked_filter(),
            .world_begins = view_of(std::as_const(world_begins)),
            .block_items = view_of(std::as_const(block_items)),
            .ranges = view_of(std::as_const(ranges)),
            .blocks = view_of(std::as_const(blocks)),
            .patches = view_of(std::as_const(patches)),
            .seen = view_of(std::as_const(rests ? not_seen : seen)),
            .node_items = view_of(std::as_const(node_items)),
            .level_begin = level_begin,
            .box_nodes = view_of(std::as_const(box_nodes)),
            .plan = rests ? &resting_plan : &plan,
            .part = part,
            .forgets_sides = {&forgets, 1}};
}

const StepStats& World::detect() {
    const auto begin = std::chrono::steady_clock::now();
    State& s = *state_;
    const auto took = [&] {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
            .count();
    };
    if (s.is_at_rest() && s.backend->can_rest()) {
        s.backend->step_at_rest();
        s.stats.stages.clear();
        s.stats.part_milliseconds.clear();
        s.stats.device_milliseconds = 0;
        s.stats.at_rest = true;
        s.stats.milliseconds = took();
        return s.stats;
    }
    const StepStats last = std::exchange(s.stats, {});
    const bool still = s.planned && s.changed.empty();
    try {
        s.refresh_views();
    } catch (const InputError&) {
        s.stats = last;  // the last step's contacts stay, too
        throw;
    } catch (...) {  // memory has run out, and views are made in part
        s.change();
        s.backend->remember(StepMemory{});
        throw;
    }
    const std::uint32_t forgets_sides = s.forgets_sides;
    const bool certifies = s.plan.settings.temporal == Temporal::certified;
    const bool few_change = constants::memory_still * s.moved_bodies() <=
                            s.plan.rigid_bodies + s.plan.deforming_bodies;
    if (certifies && few_change) s.rest.end();
    const bool rests = certifies && s.settings.may_rest && s.rest.now();
    const Scene scene = s.scene(rests, forgets_sides);
    s.stepped = s.still = false;
    try {
        s.backend->step(scene, s.stats);
    } catch (...) {
        s.change();  // what the backend has of the scene is unknown
        throw;
    }
    s.forgets_sides = false;
    s.still = still;
    if (certifies && !few_change) s.rest.note(s.stats, s.plan.measures_deformation);
    s.stats.rested = rests;
    s.end_motion();
    s.stepped = true;
    s.stats.milliseconds = took();
    return s.stats;
}

std::span<const Contact> World::contacts() const {
    const View<const Contact> contacts = state_->backend->contacts();
    return {contacts.data, contacts.size};
}

KeptContacts World::keep_contacts() {
    return {state_->backend->keep_contacts(), contacts().size()};
}

const StepStats& World::stats() const { return state_->stats; }

const Plan& World::plan() {
    if (!state_->planned) state_->make_plan();
    state_->plan.parts = state_->backend->parts();
    return state_->plan;
}

std::string World::backend() const { return state_->backend->description(); }

std::vector<World::BodyBox> World::body_boxes() const {
    state_->check_stepped("body_boxes");
    state_->backend->fetch_bodies(view_of(state_->views));
    std::vector<BodyBox> boxes;
    for (std::size_t i = 0; i < state_->views.size(); ++i)
        if (state_->views[i].active) boxes.push_back({state_->ids[i], state_->views[i].world_box});
    return boxes;
}

}  // namespace pierce
