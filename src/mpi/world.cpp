#include "pierce/mpi/world.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/base/archive.hpp"
#include "core/world/archived.hpp"
#include "mpi/failure.hpp"
#include "mpi/world_state.hpp"
#include "pierce/error.hpp"

namespace pierce::mpi {
namespace {

/// Keys of meshes of a rank begin where no other rank's come.
constexpr int rank_shift = 48;

pierce::World made_together(const Communicator& comm, const std::function<pierce::World()>& make) {
    std::optional<pierce::World> made;
    const std::exception_ptr failure = failure_of([&] { made = make(); });
    if (any_failed(comm, failure)) throw_failure(comm, failure);
    return std::move(*made);
}

}  // namespace

World::State::State(MPI_Comm ranks, const std::function<pierce::World()>& make)
    : comm(ranks), local(made_together(comm, make)), inside(WorldInside::state(local)) {
    others.resize(static_cast<std::size_t>(comm.size()));
    inside.part = rank();
    const std::uint64_t used = inside.next_key >> rank_shift;
    if (used + others.size() > largest_key >> rank_shift)
        throw InputError("the saved world has been continued by too many ranks");
    inside.next_key = (used + rank() + 1) << rank_shift;
}

World::World(MPI_Comm ranks, std::unique_ptr<Backend> backend, const Settings& settings)
    : World(std::make_unique<State>(ranks,
                                    [&] { return pierce::World(std::move(backend), settings); })) {
    ArchiveWriter archive;
    Settings mine = settings;
    transfer(archive, mine);
    const std::vector<std::string> all = state_->comm.all_gather(std::move(archive).take());
    if (std::ranges::any_of(all, [&](const std::string& its) { return its != all[0]; }))
        throw InputError("the ranks of a world have different settings");
}
World::World(std::unique_ptr<State> state) : state_(std::move(state)) {}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

int World::rank() const { return state_->comm.rank(); }
int World::ranks() const { return state_->comm.size(); }

MeshId World::add_mesh(std::string name, MeshData data, MeshOptions options) {
    return state_->local.add_mesh(std::move(name), std::move(data), std::move(options));
}
MeshId World::add_mesh(std::shared_ptr<const Mesh> mesh) {
    return state_->local.add_mesh(std::move(mesh));
}
MeshId World::add_mesh(std::string name, MeshData data, MeshId before, MeshOptions options) {
    return state_->local.add_mesh(std::move(name), std::move(data), before, std::move(options));
}
void World::remove_mesh(MeshId mesh) {
    State& s = *state_;
    const MeshEntry entry = s.inside.meshes.get(mesh, "mesh");
    s.local.remove_mesh(mesh);
    const auto known = s.known_meshes.find(entry.key);
    if (known == s.known_meshes.end() || known->second.here != mesh) return;
    // Another rank that has sent it does so once.
    if (known->second.senders.empty())
        s.known_meshes.erase(known);
    else
        known->second.here = s.inside.meshes.add(entry);
}
const Mesh& World::mesh(MeshId mesh) const { return state_->local.mesh(mesh); }

void World::State::check_free(std::uint32_t number) const {
    const auto& slots = inside.bodies.slots();
    if (number < slots.size() && slots[number].used)
        throw InputError("there is a body " + std::to_string(number) + " on rank " +
                         std::to_string(slots[number].thing.part));
}

BodyId World::State::add(std::uint32_t number, BodyId added) {
    BodyEntry body = inside.bodies.take(added, "body");
    body.part = rank();
    const auto& slots = inside.bodies.slots();
    const BodyId id{number, number < slots.size() ? slots[number].generation : 1};
    inside.bodies.put(id, std::move(body));
    news.added.push_back(id);
    has_news = own_changed = true;
    return id;
}

BodyId World::add_fixed_body(std::uint32_t number, MeshId mesh, const Pose& pose) {
    state_->check_free(number);
    return state_->add(number, state_->local.add_fixed_body(mesh, pose));
}
BodyId World::add_rigid_body(std::uint32_t number, MeshId mesh, const Pose& pose) {
    state_->check_free(number);
    return state_->add(number, state_->local.add_rigid_body(mesh, pose));
}
BodyId World::add_deforming_body(std::uint32_t number, MeshId mesh,
                                 std::span<const Vec3f> positions) {
    state_->check_free(number);
    return state_->add(number, state_->local.add_deforming_body(mesh, positions));
}

bool World::State::is_own(BodyId body) const {
    return body && belongs_to(body.index, rank()) && id(body.index) == body;
}

void World::State::check_own(std::span<const BodyId> some) const {
    for (const BodyId body : some)
        if (!is_own(body))
            throw InputError("body " + std::to_string(body.index) + " is not one of rank " +
                             std::to_string(rank()));
}

void World::State::note_changed(BodyId body) {
    changed_bodies.insert(body.index);
    has_news = true;
}

std::vector<BodyId> World::bodies() const {
    std::vector<BodyId> all;
    const auto& slots = state_->inside.bodies.slots();
    for (std::uint32_t b = 0; b < slots.size(); ++b)
        if (state_->belongs_to(b, state_->rank())) all.push_back({b, slots[b].generation});
    return all;
}
bool World::owns(BodyId body) const { return state_->is_own(body); }

void World::remove_body(BodyId body) {
    State& s = *state_;
    s.check_own({&body, 1});
    s.local.remove_body(body);
    s.removed.push_back(body.index);
    s.changed_bodies.erase(body.index);
    const auto is_of_body = [&](const BodyIdPair& pair) {
        return pair.a == body || pair.b == body;
    };
    std::erase_if(s.news.excluded, is_of_body);
    std::erase_if(s.news.included, is_of_body);
    // Another rank may have added one of that number. Where it has added the same one, and a step
    // was refused, its own stays.
    if (std::erase(s.news.added, body) == 0 || !s.heard.contains(body))
        s.news.removed.push_back(body);
    s.has_news = s.own_changed = true;
}

void World::set_collision(BodyId body, const Collision& collision) {
    state_->check_own({&body, 1});
    state_->local.set_collision(body, collision);
    state_->note_changed(body);
}
void World::set_filter(BodyId body, const Filter& filter) {
    state_->check_own({&body, 1});
    state_->local.set_filter(body, filter);
    state_->note_changed(body);
}
void World::set_pose(BodyId body, const Pose& pose) {
    state_->check_own({&body, 1});
    state_->local.set_pose(body, pose);
}
void World::set_poses(std::span<const BodyId> bodies, std::span<const Pose> poses) {
    state_->check_own(bodies);
    state_->local.set_poses(bodies, poses);
}
void World::set_positions(BodyId body, std::span<const Vec3f> positions) {
    state_->check_own({&body, 1});
    state_->local.set_positions(body, positions);
}
void World::set_positions(std::span<const BodyId> bodies, std::span<const Vec3f> positions) {
    state_->check_own(bodies);
    state_->local.set_positions(bodies, positions);
}
void World::set_motion(BodyId body, std::span<const Vec3f> start,
                       std::span<const Vec3f> positions) {
    state_->check_own({&body, 1});
    state_->local.set_motion(body, start, positions);
}
void World::set_motion(BodyId body, const Pose& start, const Pose& pose) {
    state_->check_own({&body, 1});
    state_->local.set_motion(body, start, pose);
}
void World::set_device_positions(BodyId body, const Vec3f* positions) {
    state_->check_own({&body, 1});
    state_->local.set_device_positions(body, positions);
}
void World::set_device_positions(std::span<const BodyId> bodies, const Vec3f* positions) {
    state_->check_own(bodies);
    state_->local.set_device_positions(bodies, positions);
}
void World::set_device_motion(BodyId body, const Vec3f* start, const Vec3f* positions) {
    state_->check_own({&body, 1});
    state_->local.set_device_motion(body, start, positions);
}
void World::set_device_poses(std::span<const BodyId> bodies, const float* poses) {
    state_->check_own(bodies);
    state_->local.set_device_poses(bodies, poses);
}
void World::set_device_poses(std::span<const BodyId> bodies, const double* poses) {
    state_->check_own(bodies);
    state_->local.set_device_poses(bodies, poses);
}
void World::set_stream(void* stream) { state_->local.set_stream(stream); }
void World::set_mesh(BodyId body, MeshId mesh, std::span<const Vec3f> positions) {
    state_->check_own({&body, 1});
    state_->local.set_mesh(body, mesh, positions);
    state_->note_changed(body);
}
void World::set_mesh(BodyId body, MeshId mesh) {
    state_->check_own({&body, 1});
    state_->local.set_mesh(body, mesh);
    state_->note_changed(body);
}

BodyIdPair World::State::pair_of(BodyId a, BodyId b) const {
    const auto& slots = inside.bodies.slots();
    for (const BodyId body : {a, b}) {
        if (!body) throw InputError("body handle is null");
        if (body.index < slots.size() && slots[body.index].generation > body.generation)
            throw InputError("body " + std::to_string(body.index) + " was removed");
    }
    if (a.index == b.index)
        throw InputError("body " + std::to_string(a.index) + " and itself are no pair");
    return {a, b};
}

void World::exclude(BodyId a, BodyId b) {
    const BodyIdPair pair = state_->pair_of(a, b);
    std::erase(state_->news.included, pair);
    state_->news.excluded.push_back(pair);
    state_->has_news = true;
}
void World::include(BodyId a, BodyId b) {
    const BodyIdPair pair = state_->pair_of(a, b);
    std::erase(state_->news.excluded, pair);
    state_->news.included.push_back(pair);
    state_->has_news = true;
}
void World::set_pair_filter(PairFilter filter) { state_->local.set_pair_filter(std::move(filter)); }
void World::set_world_active(std::int32_t world, bool active) {
    State& s = *state_;
    WorldInside::State::check_filter({.world = world});
    if (world == all_worlds) throw InputError("all worlds together are none that can be left out");
    if (active)
        s.left_out.erase(world);
    else
        s.left_out.insert(world);
    s.inside.left_out = s.left_out;
    for (const BodyId body : s.local.bodies_of(world)) s.inside.note_change(body);
}
void World::forget_sides() { state_->forgets_sides = true; }

const StepStats& World::detect() {
    State& s = *state_;
    s.detected = false;
    s.agree_on_news();
    s.look_around();
    std::vector<std::string> all = Exchange(s.comm, s.messages()).finish();
    s.motions = s.moved_bodies();
    s.together([&] {
        s.take_in(std::move(all));
        if (std::exchange(s.forgets_sides, false)) s.local.forget_sides();
        s.local.detect();
    });
    s.motions.clear();
    s.by_world = !s.inside.world_begins.empty();
    s.revision = s.inside.plan.revision;
    s.detected = true;
    return s.local.stats();
}

std::span<const Contact> World::contacts() const {
    if (!state_->detected) return {};
    return state_->local.contacts();
}
const StepStats& World::stats() const { return state_->local.stats(); }

double World::uneven() const {
    double sum = 0, most = 0;
    for (const double work : state_->work) {
        sum += work;
        most = std::max(most, work);
    }
    return sum > 0 ? most * static_cast<double>(state_->work.size()) / sum : 1;
}

pierce::World& World::nearby() { return state_->local; }
const pierce::World& World::nearby() const { return state_->local; }

void World::State::fail(const std::exception_ptr& failure) {
    detected = false;
    // Where the step has succeeded, motions have ended.
    for (const BodyId body : std::exchange(motions, {}))
        if (is_own(body)) entry(body.index).moved = true;
    start_over();
    throw_failure(comm, failure);
}

std::vector<BodyId> World::State::moved_bodies() const {
    std::vector<BodyId> moved;
    for (const std::uint32_t b : own)
        if (inside.bodies.slots()[b].thing.moved) moved.push_back(id(b));
    return moved;
}

void World::State::drop_ghosts() {
    const auto& slots = inside.bodies.slots();
    for (std::uint32_t b = 0; b < slots.size(); ++b)
        if (slots[b].used && slots[b].thing.part != rank()) inside.bodies.take(id(b), "body");
    for (OtherRank& other : others) {
        other.has.clear();
        // They keep meshes that they have, and take no notice of others with the same key.
        other.meshes.clear();
    }
    inside.change();
}

void World::State::start_over() {
    drop_ghosts();
    handed.emplace();
    hands_over = true;
}

}  // namespace pierce::mpi
