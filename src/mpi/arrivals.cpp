#include <algorithm>
#include <utility>

#include "mpi/world_state.hpp"

/// What comes from other ranks in a step: meshes, ghosts, and where they are now.
namespace pierce::mpi {

void World::State::take_in(std::vector<std::string> all) {
    for (std::uint32_t from = 0; from < all.size(); ++from)
        if (from != rank() && !all[from].empty())
            take_in(from, from_bytes<GhostMessage>(std::move(all[from])));
    if (!inside.planned) exclude_pairs();
    if (handed) {
        inside.refresh_views();
        inside.backend->remember(*handed);
        handed.reset();
    }
    hands_over = false;
}

void World::State::take_meshes(std::vector<SavedMesh> meshes) {
    for (SavedMesh& mesh : meshes) {
        const std::uint64_t key = mesh.key;
        if (known_meshes.contains(key)) continue;
        // Backends find by its key what they have of a mesh: there is one of each.
        const auto& slots = inside.meshes.slots();
        const auto same = std::ranges::find_if(
            slots, [&](const auto& slot) { return slot.used && slot.thing.key == key; });
        known_meshes[key] = inside.meshes.add(same != slots.end() ? MeshEntry(same->thing)
                                                                  : made_from(std::move(mesh)));
    }
}

void World::State::drop_away() {
    const auto& slots = inside.bodies.slots();
    for (std::uint32_t b = 0; b < slots.size(); ++b)
        if (slots[b].used && slots[b].thing.away) {
            inside.bodies.take(id(b), "body");
            inside.change();
        }
}

/// Puts a body where its number says, with what this rank has measured of it.
void World::State::put(const WholeBody& body, std::uint32_t owner) {
    auto& slots = inside.bodies.slots();
    BodyEntry entry = body.entry;
    entry.mesh = known_meshes.at(body.mesh_key);
    entry.part = owner;
    entry.away = false;
    // Trees point to positions until these have another version.
    entry.positions_version = inside.next_key++;
    if (body.id.index < slots.size() && slots[body.id.index].used && entry.seen.empty())
        entry.seen = std::move(slots[body.id.index].thing.seen);
    if (entry.seen.size() != patch_count(inside.mesh_of(entry).view({}))) entry.seen.clear();
    inside.bodies.put(body.id, std::move(entry));
    inside.change();
}

void World::State::take_in(std::uint32_t from, GhostMessage message) {
    const auto& slots = inside.bodies.slots();
    take_meshes(std::move(message.meshes));
    for (const std::uint32_t b : message.left) {
        if (!belongs_to(b, from)) continue;
        entry(b).away = true;
        inside.note_change(id(b));
    }
    for (const WholeBody& body : message.bodies) {
        put(body, from);
        if (!tells_seen()) continue;
        std::vector<SeenBody>& bodies = to_remember().bodies;
        bodies.resize(std::max<std::size_t>(bodies.size(), body.id.index + std::size_t{1}));
        bodies[body.id.index] = body.in_last;
    }
    for (MovedBody& moved : message.moved) {
        if (!belongs_to(moved.number, from)) continue;
        BodyEntry& body = inside.begin_motion(id(moved.number));
        if (body.motion == Motion::deforming) {
            body.positions = std::move(moved.positions);
            if (moved.tells_start) body.start = std::move(moved.start);
            body.positions_version = inside.next_key++;
        } else {
            body.pose = moved.pose;
            if (moved.tells_start) body.start_pose = moved.start_pose;
        }
    }
    if (inside.planned && message.forgotten.empty()) return;
    drop_away();  // a new plan is made in any case
    for (const std::uint64_t key : message.forgotten) {
        const auto known = known_meshes.find(key);
        if (known == known_meshes.end()) continue;
        const bool is_used = std::ranges::any_of(
            slots, [&](const auto& slot) { return slot.used && slot.thing.mesh == known->second; });
        if (!is_used) inside.meshes.remove(known->second, "mesh");
        known_meshes.erase(known);
    }
}

void World::State::exclude_pairs() {
    const auto& slots = inside.bodies.slots();
    const auto is_here = [&](BodyId body) {
        return body.index < slots.size() && slots[body.index].used &&
               slots[body.index].generation == body.generation;
    };
    inside.excluded.clear();
    for (const BodyIdPair& pair : excluded)
        if (is_here(pair.a) && is_here(pair.b)) inside.excluded.insert(pair);
}

StepMemory& World::State::to_remember() {
    if (!handed) handed = remembered();
    return *handed;
}

StepMemory World::State::remembered() {
    if (inside.planned)
        inside.backend->fetch_seen(view_of(std::as_const(inside.ids)),
                                   view_of(std::as_const(inside.seen)));
    return inside.backend->memory();
}

}  // namespace pierce::mpi
