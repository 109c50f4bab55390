#include "pierce/core/world.hpp"

#include <algorithm>
#include <utility>

#include "pierce/core/brute_force_tracer.hpp"
#include "pierce/core/bvh/bvh_tracer.hpp"
#include "pierce/core/world_state.hpp"

namespace pierce {

bool is_usable(const Pose& pose) {
    const Quaternion& q = pose.rotation;
    const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    return is_within_reach(pose.position) && norm >= constants::smallest_rotation && norm <= constants::largest_rotation;
}

bool is_usable(std::span<const Vec3f> positions) {
    return std::ranges::all_of(positions, [](Vec3f p) { return is_within_reach(p); });
}

namespace {

void check_pose(const Pose& pose, const std::string& mesh) {
    if (!is_usable(pose))
        throw InputError("pose of a body of mesh '" + mesh + "' is not finite, too far away or has no rotation");
}

void check_count(std::size_t given, const Mesh& mesh) {
    if (given != mesh.positions().size())
        throw InputError("body of mesh '" + mesh.name() + "' needs " + std::to_string(mesh.positions().size()) +
                         " positions, got " + std::to_string(given));
}

}  // namespace

World::World(std::unique_ptr<Backend> backend, Settings settings) : state_(std::make_unique<State>()) {
    if (!(settings.open_body_range > 0)) throw InputError("open_body_range must be positive");
    if (settings.full_every == 0) throw InputError("full_every must be at least 1");
    if (!(settings.walk_threshold >= 0)) throw InputError("walk_threshold must not be negative");
    if (std::isnan(settings.prediction_distance)) throw InputError("prediction_distance must be a number");
    state_->backend = std::move(backend);
    state_->settings = settings;
}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

MeshId World::add_mesh(std::string name, MeshData data) {
    return add_mesh(std::make_shared<const Mesh>(std::move(name), std::move(data)));
}

MeshId World::add_mesh(std::shared_ptr<const Mesh> mesh) {
    if (!mesh) throw InputError("there is no mesh to add");
    return state_->meshes.add({std::move(mesh), state_->next_key++, {}});
}

void World::remove_mesh(MeshId mesh) {
    const Mesh& named = this->mesh(mesh);
    for (const auto& slot : state_->bodies.slots())
        if (slot.used && slot.thing.mesh == mesh) throw InputError("mesh '" + named.name() + "' is still used by a body");
    state_->meshes.remove(mesh, "mesh");
}

const Mesh& World::mesh(MeshId mesh) const { return *state_->meshes.get(mesh, "mesh").mesh; }

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
    const BodyEntry& entry = state_->bodies.get(body, "body");
    const Mesh& mesh = state_->mesh_of(entry);
    if (vertex >= mesh.positions().size())
        throw InputError("mesh '" + mesh.name() + "' has no vertex " + std::to_string(vertex));
    if (entry.device_positions != nullptr)
        throw InputError("body " + std::to_string(body.index) + " has its positions in device memory");
    if (entry.motion == Motion::deforming) return to_double(entry.positions[vertex]);
    return frame_of(entry.pose).to_parent(to_double(mesh.positions()[vertex]));
}

void World::set_collision(BodyId body, const Collision& collision) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    state_->check_collision(
        entry, collision, "body " + std::to_string(body.index) + " of mesh '" + state_->mesh_of(entry).name() + "'");
    entry.collision = collision;
    state_->change();
}

const Collision& World::collision_of(BodyId body) const { return state_->bodies.get(body, "body").collision; }

void World::set_pose(BodyId body, const Pose& pose) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    if (entry.motion == Motion::deforming)
        throw InputError("body " + std::to_string(body.index) + " deforms: it has positions, not a pose");
    state_->begin_motion(entry);
    entry.pose = pose;
    if (!entry.usable) entry.start_pose = pose;
    entry.usable = is_usable(pose);
}

void World::set_positions(BodyId body, std::span<const Vec3f> positions) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    if (entry.motion != Motion::deforming)
        throw InputError("body " + std::to_string(body.index) + " is rigid: it has a pose, not positions");
    check_count(positions.size(), state_->mesh_of(entry));
    state_->begin_motion(entry);
    std::ranges::copy(positions, entry.positions.begin());
    if (!entry.usable) entry.start = entry.positions;
    entry.device_positions = entry.device_start = nullptr;
    entry.positions_version = state_->next_key++;
    entry.usable = is_usable(positions);
}

void World::set_motion(BodyId body, std::span<const Vec3f> start, std::span<const Vec3f> positions) {
    check_count(start.size(), state_->mesh_of(state_->bodies.get(body, "body")));
    set_positions(body, positions);
    BodyEntry& entry = state_->bodies.get(body, "body");
    entry.start.assign(start.begin(), start.end());
    entry.usable = entry.usable && is_usable(start);
}

void World::set_motion(BodyId body, const Pose& start, const Pose& pose) {
    set_pose(body, pose);
    BodyEntry& entry = state_->bodies.get(body, "body");
    entry.start_pose = start;
    entry.usable = entry.usable && is_usable(start);
}

void World::set_device_positions(BodyId body, const Vec3f* positions) {
    if (plan().sheets)
        throw InputError("a world with a sheet needs positions at both ends of a step: use set_device_motion()");
    set_device_motion(body, nullptr, positions);
}

void World::set_device_motion(BodyId body, const Vec3f* start, const Vec3f* positions) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    if (entry.motion != Motion::deforming)
        throw InputError("body " + std::to_string(body.index) + " is rigid: it has a pose, not positions");
    if (!state_->backend->runs_on_device())
        throw InputError("positions in device memory need a backend that runs there, not '" + backend() + "'");
    entry.device_positions = positions;
    entry.device_start = start;
    entry.positions_version = state_->next_key++;
    entry.usable = true;
    state_->stepped = false;
}

void World::set_mesh(BodyId body, MeshId mesh, std::span<const Vec3f> positions) {
    BodyEntry& entry = state_->bodies.get(body, "body");
    const Mesh& shape = this->mesh(mesh);
    if (entry.motion != Motion::deforming)
        throw InputError("body " + std::to_string(body.index) + " is rigid: only a deforming body changes its mesh");
    check_count(positions.size(), shape);
    if (entry.collision != Collision{} && !entry.collision.sheet && !shape.traits().closed())
        throw InputError("mesh '" + shape.name() + "' has no inside: its body can meet itself only as a sheet");
    entry.mesh = mesh;
    entry.seen.clear();
    entry.start.assign(positions.begin(), positions.end());
    entry.positions.assign(positions.begin(), positions.end());
    entry.device_positions = entry.device_start = nullptr;
    entry.positions_version = state_->next_key++;
    entry.usable = is_usable(positions);
    state_->change();
}

void World::forget_sides() { state_->forgets_sides = true; }

const StepStats& World::detect() {
    const auto begin = std::chrono::steady_clock::now();
    State& s = *state_;
    s.stats = {};
    s.refresh_views();
    Settings settings = s.settings;
    settings.temporal = s.plan.temporal;
    const std::uint32_t forgets_sides = std::exchange(s.forgets_sides, false);
    const Scene scene{view_of(s.views),
                      view_of(std::as_const(s.ids)),
                      view_of(std::as_const(s.block_items)),
                      view_of(std::as_const(s.ranges)),
                      view_of(std::as_const(s.blocks)),
                      view_of(std::as_const(s.patches)),
                      view_of(std::as_const(s.seen)),
                      settings,
                      &s.plan,
                      {&forgets_sides, 1}};
    s.backend->step(scene, s.stats);
    s.end_motion();
    s.stepped = true;
    s.stats.milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return s.stats;
}

std::span<const Contact> World::contacts() const {
    const View<const Contact> contacts = state_->backend->contacts();
    return {contacts.data, contacts.size};
}

const StepStats& World::stats() const { return state_->stats; }

const Plan& World::plan() {
    if (!state_->planned) state_->make_plan();
    return state_->plan;
}

std::string World::backend() const { return state_->backend->description(); }

std::vector<World::BodyBox> World::body_boxes() const {
    state_->backend->fetch_bodies(view_of(state_->views));
    std::vector<BodyBox> boxes;
    for (std::size_t i = 0; i < state_->views.size(); ++i)
        if (state_->views[i].active) boxes.push_back({state_->ids[i], state_->views[i].world_box});
    return boxes;
}

std::vector<std::optional<RayHit>> World::cast_rays(Vec3d origin, std::span<const Vec3d> directions) {
    state_->check_stepped("cast_rays");
    const auto usable = [](Vec3d v) { return is_finite(v); };
    if (!usable(origin) || !std::ranges::all_of(directions, usable))
        throw InputError("cast_rays needs an origin and directions that are finite");
    state_->backend->fetch_bodies(view_of(state_->views));
    const auto& views = state_->views;
    std::vector<Ray> rays;
    std::vector<std::size_t> line;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const Vec3d direction = normalized(directions[i]);
        if (length_squared(direction) == 0) continue;
        for (std::uint32_t b = 0; b < views.size(); ++b) {
            if (!views[b].active) continue;
            const Frame to_fit = relative_frame({}, views[b].fit);
            const Stretch inside = stretch_inside(views[b].fit_box, to_fit.to_parent(origin), to_fit.rotation * direction);
            if (inside.begin > inside.end || inside.end < 0) continue;
            const Frame to_space = relative_frame({}, views[b].space);
            Ray ray;
            // From just outside the box: a surface in the box's face must still lie ahead.
            ray.origin = to_space.to_parent(origin + std::max(inside.begin - 2 * views[b].touch, 0.0) * direction);
            ray.direction = to_space.rotation * direction;
            ray.t_max = views[b].fit_box.extent() + 2 * views[b].touch;
            ray.target = b;
            rays.push_back(ray);
            line.push_back(i);
        }
    }
    std::vector<Hit> hits(rays.size());
    state_->backend->closest_hits(view_of(views), view_of(std::as_const(rays)), view_of(hits));

    std::vector<std::optional<RayHit>> nearest(directions.size());
    for (std::size_t r = 0; r < rays.size(); ++r) {
        if (hits[r].triangle == no_triangle) continue;
        const BodyView& body = views[rays[r].target];
        const stages::Meeting m = stages::meet(rays[r], body.surface(), hits[r].triangle);
        const Vec3d at = body.space.to_parent(rays[r].origin + m.t * rays[r].direction);
        const double t = length(at - origin);
        std::optional<RayHit>& best = nearest[line[r]];
        if (best && best->t <= t) continue;
        const Triangle& tri = body.mesh.triangles[hits[r].triangle];
        const Vec3d a = to_double(body.positions[tri.vertex[0]]);
        const Vec3d n = cross(to_double(body.positions[tri.vertex[1]]) - a, to_double(body.positions[tri.vertex[2]]) - a);
        best = RayHit{state_->ids[rays[r].target], hits[r].triangle, t, body.space.rotation * normalized(n)};
    }
    return nearest;
}

std::unique_ptr<Backend> reference_backend() {
    return std::make_unique<PipelineBackend<SerialExecutor, BruteForceTracer>>(
        "reference, 1 thread", std::make_unique<SerialExecutor>(), std::make_unique<BruteForceTracer>());
}

std::unique_ptr<Backend> bvh_backend() {
    return std::make_unique<PipelineBackend<SerialExecutor, BvhTracer<SerialExecutor>>>(
        "bvh, 1 thread", std::make_unique<SerialExecutor>(), std::make_unique<BvhTracer<SerialExecutor>>());
}

}  // namespace pierce
