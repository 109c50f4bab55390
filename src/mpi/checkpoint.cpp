#include <algorithm>
#include <string>
#include <utility>

#include "core/partition/body_reach.hpp"
#include "core/partition/contact_order.hpp"
#include "core/partition/memory_parts.hpp"
#include "core/step/common/pairs.hpp"
#include "mpi/items.hpp"
#include "mpi/world_state.hpp"
#include "pierce/error.hpp"
#include "pierce/reference_backends.hpp"

/// What all ranks have, in one place: contacts, and worlds that are saved and read.
namespace pierce::mpi {

std::vector<Contact> World::gather_contacts(int root) const {
    const State& s = *state_;
    std::vector<std::string> to(s.others.size());
    const std::exception_ptr failure = failure_of([&] {
        if (root < 0 || root >= ranks())
            throw InputError("there is no rank " + std::to_string(root));
        // What is saved is planned, but no step has seen it.
        if (s.detected && (!s.inside.planned || s.inside.plan.revision != s.revision))
            throw InputError(
                "gather_contacts needs a detect() after bodies were added, removed or changed");
        const stages::PairKeys keys{s.by_world};
        const View<const BodyView> bodies = view_of(s.inside.views);
        std::vector<GatheredContact> mine;
        for (const Contact& c : contacts()) {
            GatheredContact gathered;
            gathered.pair_key = keys.key(bodies, c.a.index, c.b.index);
            gathered.of_sheets = !is_by_ray(c, bodies);
            gathered.contact = c;
            mine.push_back(gathered);
        }
        append_items<GatheredContact>(to[static_cast<std::size_t>(root)], mine);
    });
    if (any_failed(s.comm, failure)) throw_failure(s.comm, failure);
    std::vector<GatheredContact> all;
    for (const std::string& its : Exchange(s.comm, std::move(to)).finish()) {
        std::size_t at = 0;
        if (!its.empty()) take_items(its, at, all);
    }
    // All contacts of a pair come from one rank, in their order.
    std::ranges::stable_sort(all, {}, [](const GatheredContact& gathered) {
        return std::pair(gathered.of_sheets, gathered.pair_key);
    });
    std::vector<Contact> contacts;
    contacts.reserve(all.size());
    for (const GatheredContact& gathered : all) contacts.push_back(gathered.contact);
    return contacts;
}

void World::save(std::ostream& out) const {
    State& s = *state_;
    s.agree_on_news();
    std::vector<std::string> to(s.others.size());
    StepMemory memory = s.memory_to_share();
    s.together([&] {
        s.make_lists();
        s.inside.bring_places(s.own);
        Handover handover;
        std::set<std::uint64_t> meshes;
        for (const std::uint32_t b : s.own) {
            s.add_mesh_to(handover.meshes, b, meshes);
            WholeBody body = s.whole(b, &memory);
            if (s.entry(b).is_on_device()) body.entry.moved = false;  // the step is over
            handover.bodies.push_back(std::move(body));
        }
        handover.memory = std::move(memory);
        handover.memory.bodies.clear();
        to[0] = to_bytes(handover);
    });
    const std::vector<std::uint64_t> next_keys = s.comm.all_gather(s.inside.next_key);
    std::vector<std::string> all = Exchange(s.comm, std::move(to)).finish();
    s.together([&] {
        if (s.rank() != 0) return;
        pierce::World whole(reference_backend(), s.inside.settings);
        WorldInside::State& inside = WorldInside::state(whole);
        inside.next_key = *std::ranges::max_element(next_keys);
        inside.excluded = s.excluded;
        inside.left_out = s.left_out;
        inside.forgets_sides = s.forgets_sides;
        // Numbers that were used before have their generations.
        for (const auto& slot : s.inside.bodies.slots())
            inside.bodies.slots().push_back({{}, slot.generation, false});
        std::map<std::uint64_t, MeshId> meshes;
        std::vector<StepMemory> memories;
        std::vector<SeenBody> seen;
        for (std::string& bytes : all) {
            Handover handover = from_bytes<Handover>(std::move(bytes));
            for (SavedMesh& mesh : handover.meshes) {
                const std::uint64_t key = mesh.key;
                if (!meshes.contains(key))
                    meshes[key] = inside.meshes.add(made_from(std::move(mesh)));
            }
            for (WholeBody& body : handover.bodies) {
                body.entry.mesh = meshes.at(body.mesh_key);
                seen.resize(std::max<std::size_t>(seen.size(), body.id.index + 1));
                seen[body.id.index] = body.in_last;
                inside.bodies.put(body.id, std::move(body.entry));
            }
            memories.push_back(std::move(handover.memory));
        }
        StepMemory joined = join_memory(memories, {});
        joined.bodies = std::move(seen);
        inside.backend->remember(joined);
        whole.save(out);
    });
}

World World::restore(MPI_Comm ranks, std::istream& in, std::unique_ptr<Backend> backend) {
    std::unique_ptr<pierce::World> whole;
    auto state = std::make_unique<State>(ranks, [&] {
        whole = std::make_unique<pierce::World>(pierce::World::restore(in, reference_backend()));
        const WorldInside::State& its = WorldInside::state(*whole);
        pierce::World local(std::move(backend), its.settings);
        WorldInside::state(local).next_key = its.next_key;
        return local;
    });
    State& s = *state;
    WorldInside::State& from = WorldInside::state(*whole);
    std::vector<PlacedBody> bodies;
    s.together([&] {
        from.refresh_views();
        for (std::uint32_t b = 0; b < from.views.size(); ++b)
            if (from.ids[b])
                bodies.push_back(placed(b, from.views[b],
                                        from.views[b].active
                                            ? reach_on_host(from.views[b], from.plan.settings)
                                            : Box{}));
    });
    const std::vector<std::uint32_t> owners = s.cut(bodies);
    s.together([&] {
        StepMemory memory = from.backend->memory();
        s.handed = memory_of_part(memory, facts_by_number(bodies), owners, s.rank());
        s.handed->bodies.resize(memory.bodies.size());
        s.hands_over = true;
        s.excluded = from.excluded;
        s.left_out = s.inside.left_out = from.left_out;
        s.forgets_sides = from.forgets_sides;
        const auto& slots = from.bodies.slots();
        for (std::uint32_t b = 0; b < slots.size(); ++b) {
            s.inside.bodies.slots().push_back({{}, slots[b].generation, false});
            if (!slots[b].used || owners[b] != s.rank()) continue;
            BodyEntry body = slots[b].thing;
            const MeshEntry& mesh = from.meshes.get(body.mesh, "mesh");
            MeshId& here = s.known_meshes[mesh.key].here;
            if (!here) here = s.inside.meshes.add(mesh);
            body.mesh = here;
            body.part = s.rank();
            s.inside.bodies.put({b, slots[b].generation}, std::move(body));
            if (b < memory.bodies.size()) s.handed->bodies[b] = memory.bodies[b];
        }
        s.inside.change();
    });
    return World(std::move(state));
}

}  // namespace pierce::mpi
