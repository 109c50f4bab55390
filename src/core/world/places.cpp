#include <algorithm>
#include <string>

#include "core/base/usable.hpp"
#include "core/world/world_state.hpp"
#include "pierce/error.hpp"
#include "pierce/world.hpp"

/// Where bodies are: their poses and positions in memory of the host.
namespace pierce {

bool is_usable(std::span<const Vec3f> positions) {
    return std::ranges::all_of(positions, [](Vec3f p) { return is_within_reach(p); });
}

void check_count(std::size_t given, const Mesh& mesh) {
    if (given != mesh.positions().size())
        throw InputError("body of mesh '" + mesh.name() + "' needs " +
                         std::to_string(mesh.positions().size()) + " positions, got " +
                         std::to_string(given));
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
    if (!is_usable(entry.start_pose)) entry.start_pose = pose;
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
    if ((!entry.usable || entry.is_on_device()) && !is_usable(entry.start))
        entry.start = entry.positions;
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
    BodyEntry& entry = state_->bodies.get(body, "body");
    state_->check_has_positions(body);
    check_count(start.size(), state_->mesh_of(entry));
    check_count(positions.size(), state_->mesh_of(entry));
    entry.last_positions = nullptr;  // where the last step has ended is no matter
    set_positions(body, positions);
    entry.start.assign(start.begin(), start.end());
    entry.usable = entry.usable && is_usable(start);
}

void World::set_motion(BodyId body, const Pose& start, const Pose& pose) {
    BodyEntry& entry = state_->place(body, pose);
    entry.start_pose = start;
    entry.usable = entry.usable && is_usable(start);
}

}  // namespace pierce
