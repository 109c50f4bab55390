#include "pierce/world.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/usable.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/mesh/patch.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/world/world_state.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"

namespace pierce {

bool is_usable(std::span<const Vec3f> positions) {
    return std::ranges::all_of(positions, [](Vec3f p) { return is_within_reach(p); });
}

namespace {

void check_pose(const Pose& pose, const std::string& mesh) {
    if (!is_usable(pose))
        throw InputError("pose of a body of mesh '" + mesh +
                         "' is not finite, too far away or has no rotation");
}

void check_count(std::size_t given, const Mesh& mesh) {
    if (given != mesh.positions().size())
        throw InputError("body of mesh '" + mesh.name() + "' needs " +
                         std::to_string(mesh.positions().size()) + " positions, got " +
                         std::to_string(given));
}

}  // namespace

World::World(const Settings& settings) : World(reference_backend(), settings) {}

World::World(std::unique_ptr<Backend> backend, const Settings& settings)
    : state_(std::make_unique<State>()) {
    if (backend == nullptr) throw InputError("a world needs a backend");
    if (settings.coverage > Coverage::overlaps || settings.temporal > Temporal::certified)
        throw InputError("coverage or temporal has a value without a meaning");
    if (!(settings.open_body_range > 0)) throw InputError("open_body_range must be positive");
    if (!(settings.margin >= 0) || std::isinf(settings.margin))
        throw InputError("margin must be finite and not negative");
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
    state_->bodies.remove(body, "body");
    state_->change();
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
    entry.collision = collision;
    state_->change();
}

const Collision& World::collision_of(BodyId body) const {
    return state_->bodies.get(body, "body").collision;
}

void World::State::check_have_poses(std::span<const BodyId> some) const {
    for (BodyId body : some)
        if (bodies.get(body, "body").motion == Motion::deforming)
            throw InputError("body " + std::to_string(body.index) +
                             " deforms: it has positions, not a pose");
}

void World::State::check_has_positions(BodyId body) const {
    if (bodies.get(body, "body").motion != Motion::deforming)
        throw InputError("body " + std::to_string(body.index) +
                         " does not deform: it has a pose, not positions");
}

BodyEntry& World::State::place(BodyId body, const Pose& pose) {
    check_have_poses({&body, 1});
    BodyEntry& entry = begin_motion(body);
    entry.leave_device();
    entry.pose = pose;
    if (!entry.usable) entry.start_pose = pose;
    entry.usable = is_usable(pose);
    return entry;
}

void World::set_pose(BodyId body, const Pose& pose) {
    const BodyEntry& entry = state_->bodies.get(body, "body");
    const bool is_there = entry.motion != Motion::deforming && !entry.moved && entry.usable &&
                          !entry.is_on_device() && are_identical(entry.pose, pose);
    // Solvers set the poses of bodies at rest, too.
    if (!is_there) state_->place(body, pose);
}

namespace {

void check_lists(std::size_t bodies, std::size_t poses) {
    if (bodies != poses)
        throw InputError(std::to_string(bodies) + " bodies need as many poses, got " +
                         std::to_string(poses));
}

/// Calls set(body, pose) for bodies and their poses in seven numbers each.
template <class T, class Set>
void set_from_numbers(std::span<const BodyId> bodies, std::span<const T> poses, const Set& set) {
    constexpr std::size_t numbers = 7;
    if (poses.size() % numbers != 0)
        throw InputError("poses have seven numbers each, got " + std::to_string(poses.size()) +
                         " numbers");
    check_lists(bodies.size(), poses.size() / numbers);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        const auto at = [&](std::size_t k) { return static_cast<double>(poses[numbers * i + k]); };
        set(bodies[i], Pose{{at(0), at(1), at(2)}, {at(3), at(4), at(5), at(6)}});
    }
}

}  // namespace

void World::set_poses(std::span<const BodyId> bodies, std::span<const Pose> poses) {
    check_lists(bodies.size(), poses.size());
    state_->check_have_poses(bodies);
    for (std::size_t i = 0; i < bodies.size(); ++i) set_pose(bodies[i], poses[i]);
}

void World::set_poses(std::span<const BodyId> bodies, std::span<const double> poses) {
    state_->check_have_poses(bodies);
    set_from_numbers(bodies, poses, [&](BodyId body, const Pose& pose) { set_pose(body, pose); });
}

void World::set_poses(std::span<const BodyId> bodies, std::span<const float> poses) {
    state_->check_have_poses(bodies);
    set_from_numbers(bodies, poses, [&](BodyId body, const Pose& pose) { set_pose(body, pose); });
}

void World::set_positions(BodyId body, std::span<const Vec3f> positions) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    state_->check_has_positions(body);
    check_count(positions.size(), state_->mesh_of(entry));
    state_->begin_motion(body);
    std::ranges::copy(positions, entry.positions.begin());
    if (!entry.usable) entry.start = entry.positions;
    entry.leave_device();
    entry.positions_version = state_->next_key++;
    entry.usable = is_usable(positions);
}

void World::set_positions(std::span<const BodyId> bodies, std::span<const Vec3f> positions) {
    std::size_t count = 0;
    for (const BodyId body : bodies) {
        const BodyEntry& entry = state_->bodies.get(body, "body");
        state_->check_has_positions(body);
        count += state_->mesh_of(entry).positions().size();
    }
    if (positions.size() != count)
        throw InputError("the bodies have " + std::to_string(count) + " vertices, got " +
                         std::to_string(positions.size()) + " positions");
    for (const BodyId body : bodies) {
        const std::size_t own = mesh(mesh_of(body)).positions().size();
        set_positions(body, positions.first(own));
        positions = positions.subspan(own);
    }
}

void World::set_motion(BodyId body, std::span<const Vec3f> start,
                       std::span<const Vec3f> positions) {
    check_count(start.size(), state_->mesh_of(state_->bodies.get(body, "body")));
    set_positions(body, positions);
    BodyEntry& entry = state_->bodies.get(body, "body");
    entry.start.assign(start.begin(), start.end());
    entry.usable = entry.usable && is_usable(start);
}

void World::set_motion(BodyId body, const Pose& start, const Pose& pose) {
    BodyEntry& entry = state_->place(body, pose);
    entry.start_pose = start;
    entry.usable = entry.usable && is_usable(start);
}

void World::set_mesh(BodyId body, MeshId mesh, std::span<const Vec3f> positions) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    const Mesh& shape = this->mesh(mesh);
    if (entry.motion != Motion::deforming)
        throw InputError("body " + std::to_string(body.index) +
                         " is rigid: its mesh is set without positions");
    check_count(positions.size(), shape);
    state_->check_collision(entry.motion, shape, entry.collision,
                            "body " + std::to_string(body.index));
    entry.mesh = mesh;
    // The next step compares with the last shape, vertex by vertex, if both have as many patches.
    if (entry.seen.size() != patch_count(shape.view({}))) entry.seen.clear();
    entry.start.assign(positions.begin(), positions.end());
    entry.positions.assign(positions.begin(), positions.end());
    entry.leave_device();
    entry.positions_version = state_->next_key++;
    entry.usable = is_usable(positions);
    state_->change();
}

void World::set_mesh(BodyId body, MeshId mesh) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    state_->meshes.get(mesh, "mesh");
    if (entry.motion == Motion::deforming)
        throw InputError("body " + std::to_string(body.index) + " deforms: a mesh needs positions");
    entry.mesh = mesh;
    state_->change();
}

void World::forget_sides() { state_->forgets_sides = true; }

const StepStats& World::detect() {
    const auto begin = std::chrono::steady_clock::now();
    State& s = *state_;
    const auto took = [&] {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
            .count();
    };
    if (s.is_at_rest() && s.backend->step_at_rest()) {
        s.stats.stages.clear();
        s.stats.part_milliseconds.clear();
        s.stats.device_milliseconds = 0;
        s.stats.at_rest = true;
        s.stats.milliseconds = took();
        return s.stats;
    }
    s.stats = {};
    const bool still = s.planned && s.changed.empty();
    try {
        s.refresh_views();
    } catch (const InputError&) {
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
    const Scene scene{.bodies = view_of(s.views),
                      .ids = view_of(std::as_const(s.ids)),
                      .changed = view_of(std::as_const(s.refreshed)),
                      .excluded = view_of(std::as_const(s.excluded_pairs)),
                      .pair_filter = s.asked_filter(),
                      .world_begins = view_of(std::as_const(s.world_begins)),
                      .block_items = view_of(std::as_const(s.block_items)),
                      .ranges = view_of(std::as_const(s.ranges)),
                      .blocks = view_of(std::as_const(s.blocks)),
                      .patches = view_of(std::as_const(s.patches)),
                      .seen = view_of(std::as_const(rests ? s.not_seen : s.seen)),
                      .node_items = view_of(std::as_const(s.node_items)),
                      .level_begin = s.level_begin,
                      .box_nodes = view_of(std::as_const(s.box_nodes)),
                      .plan = rests ? &s.resting_plan : &s.plan,
                      .part = s.part,
                      .forgets_sides = {&forgets_sides, 1}};
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
