#include <algorithm>
#include <utility>

#include "core/partition/memory_parts.hpp"
#include "core/partition/space_cut.hpp"
#include "mpi/items.hpp"
#include "mpi/world_state.hpp"
#include "pierce/constants.hpp"

/// Bodies that go from one rank to another, with what is remembered of their pairs.
namespace pierce::mpi {
StepMemory memory_of_part(const StepMemory& all, std::span<const BodyFacts> facts,
                          std::span<const std::uint32_t> owners, std::uint32_t part) {
    StepMemory memory = part_of_memory(all, [&](Pair pair) {
        const auto is_there = [&](std::uint32_t b) { return b < facts.size() && facts[b].exists; };
        const auto motion = [&](std::uint32_t b) {
            return facts[b].moves ? Motion::rigid : Motion::fixed;
        };
        return is_there(pair.a) && is_there(pair.b) &&
               part_of_pair(motion(pair.a), owners[pair.a], motion(pair.b), owners[pair.b]) == part;
    });
    memory.bodies.clear();
    return memory;
}

std::vector<BodyFacts> facts_by_number(std::span<const PlacedBody> all) {
    std::vector<BodyFacts> facts;
    for (const PlacedBody& body : all) {
        facts.resize(std::max<std::size_t>(facts.size(), body.number + std::size_t{1}));
        facts[body.number] = body.facts;
    }
    return facts;
}

std::vector<PlacedBody> World::State::all_placed() const {
    std::vector<PlacedBody> mine;
    mine.reserve(own.size());
    for (const std::uint32_t b : own) mine.push_back(placed(b, inside.views[b], reach[b]));
    std::string bytes;
    append_items<PlacedBody>(bytes, mine);
    std::vector<PlacedBody> all;
    for (const std::string& its : comm.all_gather(bytes)) {
        std::size_t at = 0;
        take_items(its, at, all);
    }
    return all;
}

PlacedBody placed(std::uint32_t number, const BodyView& view, const Box& reach) {
    return {.number = number,
            .facts = {.weight = static_cast<float>(view.mesh.triangles.size),
                      .exists = true,
                      .active = !reach.empty(),
                      .moves = view.motion != Motion::fixed,
                      .on_device = false,
                      .is_ghost = false},
            .reach = reach};
}

std::vector<std::uint32_t> World::State::cut(std::span<const PlacedBody> all) const {
    const std::vector<BodyFacts> facts = facts_by_number(all);
    std::vector<Box> reaches(facts.size());
    for (const PlacedBody& body : all) reaches[body.number] = body.reach;
    const std::vector<double> equal(others.size(), 1.0);
    std::vector<double> shares = equal;
    SpaceCut space;
    for (std::uint32_t round = 0; round < constants::cut_rounds; ++round) {
        space.divide(facts, reaches, shares);
        // Every rank looks around for itself.
        double load = 0;
        space.seen_from(rank(), facts, reaches, constants::spare_reach * space.mean_extent(),
                        &load);
        shares = corrected_shares(std::move(shares), equal, comm.all_gather(load));
    }
    return {space.owners().begin(), space.owners().end()};
}

StepMemory World::State::memory_to_share() {
    StepMemory memory;
    together([&] {
        memory = handed ? *handed : remembered();
        make_lists();
    });
    // A rank whose last step has rested, or that proves nothing, does not know where bodies were.
    const auto knows = static_cast<std::uint8_t>(!memory.bodies.empty() || own.empty());
    const std::vector<std::uint8_t> all = comm.all_gather(knows);
    if (std::ranges::find(all, 0) == all.end()) return memory;
    memory.bodies.clear();
    memory.directed.clear();
    memory.blocks.clear();
    memory.patches.clear();
    memory.vertices.clear();
    memory.contacts.clear();
    return memory;
}

Migration World::migrate() {
    State& s = *state_;
    s.agree_on_news();
    s.look_around();
    const std::vector<PlacedBody> placed = s.all_placed();
    const std::vector<BodyFacts> facts = facts_by_number(placed);
    const std::vector<std::uint32_t> owners = s.cut(placed);
    Migration migration;
    std::vector<std::string> to(s.others.size());
    StepMemory memory = s.memory_to_share(), kept;
    s.together([&] {
        s.handed.emplace();
        s.handed->bodies = memory.bodies;
        s.hands_over = true;
        std::vector<std::uint32_t> leaving;
        for (const std::uint32_t b : s.own)
            if (owners[b] != s.rank()) leaving.push_back(b);
        s.inside.bring_places(leaving);
        for (std::uint32_t other = 0; other < to.size(); ++other) {
            Handover handover;
            handover.memory = memory_of_part(memory, facts, owners, other);
            if (other == s.rank()) {
                kept = std::move(handover.memory);
                continue;
            }
            std::set<std::uint64_t> meshes;
            for (const std::uint32_t b : s.own) {
                if (owners[b] != other) continue;
                s.add_mesh_to(handover.meshes, b, meshes);
                handover.bodies.push_back(s.whole(b, &memory));
            }
            s.others[other].got.insert(meshes.begin(), meshes.end());
            to[other] = to_bytes(handover);
        }
    });
    std::vector<std::string> all = Exchange(s.comm, std::move(to)).finish();
    s.together([&] {
        s.drop_ghosts();
        for (const std::uint32_t b : s.own)
            if (owners[b] != s.rank()) {
                migration.left.push_back(s.id(b));
                s.inside.bodies.take(s.id(b), "body");
            }
        s.handed->bodies.resize(s.inside.bodies.slots().size());
        std::vector<StepMemory> memories;
        memories.push_back(std::move(kept));
        for (std::uint32_t from = 0; from < all.size(); ++from) {
            if (from == s.rank()) continue;
            Handover handover = from_bytes<Handover>(std::move(all[from]));
            s.take_meshes(from, std::move(handover.meshes));
            for (const WholeBody& body : handover.bodies) {
                s.put(body, s.rank());
                migration.arrived.push_back(body.id);
                s.handed->bodies.resize(
                    std::max<std::size_t>(s.handed->bodies.size(), body.id.index + 1));
                s.handed->bodies[body.id.index] = body.in_last;
            }
            memories.push_back(std::move(handover.memory));
        }
        std::vector<SeenBody> bodies = std::move(s.handed->bodies);
        s.handed = join_memory(memories, {});
        s.handed->bodies = std::move(bodies);
        std::ranges::sort(migration.arrived);
        s.changed_bodies.clear();
        s.own_changed = s.has_news = true;
    });
    return migration;
}

}  // namespace pierce::mpi
