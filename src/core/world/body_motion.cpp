#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/world/world_state.hpp"
#include "pierce/error.hpp"

/// From where to where bodies move in a step.
namespace pierce {

void World::State::note_change(BodyId body) {
    changed.push_back(body.index);
    stepped = false;
}

bool World::State::bring_last_place(std::uint32_t index) {
    const BodyEntry& body = bodies.slots()[index].thing;
    if (!body.usable || body.device_pose.exists()) return false;
    if (body.last_positions == nullptr) return true;
    // The caller has the positions as long as no others are set. Only sheets need them.
    if (!plan.sheets || body.last_positions != body.device_positions) return false;
    bring_places({&index, 1}, false);
    return true;
}

BodyEntry& World::State::begin_motion(BodyId id) {
    BodyEntry& body = bodies.get(id, "body");
    if (!body.moved) {
        body.start.resize(body.positions.size());  // without memory, nothing has changed yet
        note_change(id);
        const bool is_known = bring_last_place(id.index);
        body.moved = true;
        body.start_pose = body.pose;
        body.start.swap(body.positions);
        if (!is_known) body.forget_start();
    }
    stepped = false;
    return body;
}

std::size_t World::State::moved_bodies() const {
    return static_cast<std::size_t>(std::ranges::count_if(changed, [&](std::uint32_t i) {
        const BodyEntry& body = bodies.slots()[i].thing;
        return body.moved || body.is_on_device();
    }));
}

void World::State::check_stepped(const char* who) const {
    if (!stepped)
        throw InputError(std::string(who) +
                         " needs a detect() after bodies were added, removed, moved or changed");
}

void World::State::end_motion() {
    for (const std::uint32_t i : refreshed) {
        BodyEntry& body = bodies.slots()[i].thing;
        body.moved = false;
        body.last_positions = body.device_positions;
    }
    changed_last.swap(changed);
    changed.clear();
}

}  // namespace pierce
