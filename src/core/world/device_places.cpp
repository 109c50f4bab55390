#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/usable.hpp"
#include "core/body/body_view.hpp"
#include "core/body/fetched_place.hpp"
#include "core/device/view.hpp"
#include "core/world/world_state.hpp"
#include "pierce/device_contacts.hpp"
#include "pierce/error.hpp"

/// Places and contacts in device memory.
namespace pierce {
namespace {

constexpr std::size_t pose_numbers = 7;

void require_device(const Backend& backend, const char* what) {
    if (!backend.runs_on_device())
        throw InputError(std::string(what) +
                         " in device memory need a backend that runs there, not '" +
                         backend.description() + "'");
}

void require_address(const void* address, const char* what) {
    if (address == nullptr)
        throw InputError(std::string(what) + " in device memory have no address");
}

/// Gives bodies the poses pose_at(k), where k is the first of their seven numbers. Throws before
/// any change if one of them cannot have a pose there.
template <class PoseAt>
void set_device_pose(WorldInside::State& state, std::span<const BodyId> bodies,
                     const PoseAt& pose_at) {
    state.check_have_poses(bodies);
    if (state.planned && state.plan.sheets)
        throw InputError("a world with a sheet cannot have poses in device memory");
    for (std::size_t k = 0; k < bodies.size(); ++k) {
        BodyEntry& entry = state.bodies.get(bodies[k], "body");
        state.note_change(bodies[k]);
        entry.device_pose = pose_at(pose_numbers * k);
        entry.usable = true;
    }
}

}  // namespace

std::vector<std::uint32_t> World::State::used_bodies() const {
    std::vector<std::uint32_t> all;
    for (std::uint32_t b = 0; b < bodies.slots().size(); ++b)
        if (bodies.slots()[b].used) all.push_back(b);
    return all;
}

bool BodyEntry::is_placed() const {
    if (!usable || !is_on_device()) return usable;
    return motion == Motion::deforming ? is_usable(positions) : is_usable(pose);
}

void World::State::bring_places(std::span<const std::uint32_t> some, bool with_starts) {
    std::vector<std::uint32_t> there, as_listed;
    std::vector<BodyView> places;
    for (const std::uint32_t b : some) {
        const BodyEntry& body = bodies.slots()[b].thing;
        if (!body.is_on_device()) continue;
        BodyView& place = places.emplace_back();
        place.positions = view_of(body.positions);
        place.device_positions = body.device_positions;
        place.device_start = with_starts ? body.device_start : nullptr;
        place.device_pose = body.device_pose;
        as_listed.push_back(static_cast<std::uint32_t>(there.size()));
        there.push_back(b);
    }
    if (there.empty()) return;
    const View<const FetchedPlace> fetched = backend->fetch_places(
        view_of(std::as_const(places)), view_of(std::as_const(as_listed)));
    for (std::uint32_t k = 0; k < fetched.size; ++k) {
        BodyEntry& body = bodies.slots()[there[k]].thing;
        const auto& [pose, positions, start] = fetched[k];
        if (body.device_pose.exists()) {
            body.pose = pose;
            continue;
        }
        std::ranges::copy(positions, body.positions.begin());
        // Trees of the host that were made of them are of others now.
        body.positions_version = next_key++;
        if (there[k] < views.size()) views[there[k]].positions_version = body.positions_version;
        if (start.size > 0) body.start.assign(start.begin(), start.end());
    }
}

const BodyEntry& World::State::placed_body(BodyId body) {
    const BodyEntry& entry = bodies.get(body, "body");
    bring_places({&body.index, 1});
    return entry;
}

void World::set_device_positions(BodyId body, const Vec3f* positions) {
    if (!state_->planned) state_->make_plan();
    if (state_->plan.sheets)
        throw InputError(
            "a world with a sheet needs positions at both ends of a step: use set_device_motion()");
    require_address(positions, "positions");
    state_->put_on_device(body, nullptr, positions);
}

void World::set_device_positions(std::span<const BodyId> bodies, const Vec3f* positions) {
    for (const BodyId body : bodies) state_->check_has_positions(body);
    if (!bodies.empty()) require_address(positions, "positions");
    for (const BodyId body : bodies) {
        set_device_positions(body, positions);
        positions += mesh(mesh_of(body)).positions().size();
    }
}

void World::set_device_motion(BodyId body, const Vec3f* start, const Vec3f* positions) {
    require_address(start, "positions at the start");
    require_address(positions, "positions");
    state_->put_on_device(body, start, positions);
}

void World::State::put_on_device(BodyId body, const Vec3f* start, const Vec3f* positions) {
    check_has_positions(body);
    require_device(*backend, "positions");
    BodyEntry& entry = bodies.get(body, "body");
    note_change(body);
    entry.device_positions = positions;
    entry.device_start = start;
    entry.positions_version = next_key++;
    entry.usable = true;
}

void World::set_device_poses(std::span<const BodyId> bodies, const float* poses) {
    require_device(*state_->backend, "poses");
    if (!bodies.empty()) require_address(poses, "poses");
    set_device_pose(*state_, bodies, [&](std::size_t at) {
        return DevicePose{.floats = poses + at, .doubles = nullptr};
    });
}

void World::set_device_poses(std::span<const BodyId> bodies, const double* poses) {
    require_device(*state_->backend, "poses");
    if (!bodies.empty()) require_address(poses, "poses");
    set_device_pose(*state_, bodies, [&](std::size_t at) {
        return DevicePose{.floats = nullptr, .doubles = poses + at};
    });
}

void World::set_stream(void* stream) {
    require_device(*state_->backend, "places");
    state_->backend->set_stream(stream);
}

DeviceContacts World::device_contacts(std::uint32_t part) const {
    require_device(*state_->backend, "contacts");
    state_->check_stepped("device_contacts");
    return state_->backend->device_contacts(part,
                                            static_cast<std::uint32_t>(state_->worlds.size()));
}

}  // namespace pierce
