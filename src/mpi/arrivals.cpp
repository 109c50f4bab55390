#include <algorithm>
#include <utility>

#include "mpi/world_state.hpp"

/// What comes from other ranks in a step: meshes, ghosts, and where they are now.
namespace pierce::mpi {

void World::State::take_in(std::vector<std::string> all) {
    std::vector<GhostMessage> messages(all.size());
    for (std::uint32_t from = 0; from < all.size(); ++from)
        if (from != rank() && !all[from].empty())
            messages[from] = from_bytes<GhostMessage>(std::move(all[from]));
    // What is remembered is about the bodies of the last step, before others come.
    if (tells_seen() && std::ranges::any_of(messages, [](const GhostMessage& message) {
            return !message.bodies.empty();
        }))
        to_remember();
    for (std::uint32_t from = 0; from < messages.size(); ++from)
        if (!messages[from].empty()) take_in(from, std::move(messages[from]));
    if (!inside.planned) exclude_pairs();
    if (handed) {
        inside.refresh_views();
        inside.backend->remember(*handed);
        handed.reset();
    }
    hands_over = false;
}

void World::State::take_meshes(std::uint32_t from, std::vector<SavedMesh> meshes) {
    for (SavedMesh& mesh : meshes) {
        const std::uint64_t key = mesh.key;
        KnownMesh& known = known_meshes[key];
        known.senders.insert(from);
        if (known.here) continue;
        // Backends find by its key what they have of a mesh: there is one of each.
        const auto& slots = inside.meshes.slots();
        const auto same = std::ranges::find_if(
            slots, [&](const auto& slot) { return slot.used && slot.thing.key == key; });
        known.here = inside.meshes.add(same != slots.end() ? MeshEntry(same->thing)
                                                           : made_from(std::move(mesh)));
    }
}

/// A rank has removed a mesh. It stays as long as another rank may name it, or a body here has it.
void World::State::forget_mesh(std::uint32_t from, std::uint64_t key) {
    const auto known = known_meshes.find(key);
    if (known == known_meshes.end()) return;
    auto& [here, senders] = known->second;
    senders.erase(from);
    if (!senders.empty() || std::ranges::any_of(inside.bodies.slots(), [&](const auto& slot) {
            return slot.used && slot.thing.mesh == here;
        }))
        return;
    inside.meshes.remove(here, "mesh");
    known_meshes.erase(known);
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
    entry.mesh = known_meshes.at(body.mesh_key).here;
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
    take_meshes(from, std::move(message.meshes));
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
    for (const std::uint64_t key : message.forgotten) forget_mesh(from, key);
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
    if (!inside.planned) inside.make_plan();
    inside.backend->fetch_seen(view_of(std::as_const(inside.ids)),
                               view_of(std::as_const(inside.seen)));
    return inside.backend->memory();
}

}  // namespace pierce::mpi
