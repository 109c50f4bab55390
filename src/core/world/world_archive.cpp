#include <istream>
#include <iterator>
#include <map>
#include <ostream>
#include <set>

#include "core/base/archive.hpp"
#include "core/device/view.hpp"
#include "core/mesh/patch.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/step/memory_check.hpp"
#include "core/world/archived.hpp"
#include "core/world/world_state.hpp"

/// Saved worlds: a header (mark, version, length and checksum of what follows), then settings,
/// meshes, bodies and what the last step keeps for the next.
namespace pierce {
namespace {

constexpr std::uint64_t mark = 0x646c726f77637270;  // "prcworld"
constexpr std::uint32_t version = 5;
constexpr std::uint32_t most_generations = 1u << 31;  ///< as many again are left for what comes

void require(bool holds, const char* what) {
    if (!holds) throw InputError(std::string("a saved world holds ") + what);
}

/// Reads slots as they were written: which slots are used, and what is in them.
template <class Saved, class Tag, class Thing, class Take>
void restore_slots(ArchiveReader& archive, SlotMap<Tag, Thing>& map, Take take) {
    const std::uint64_t count = transfer_length(archive, 0);
    for (std::uint64_t i = 0; i < count; ++i) {
        auto& slot = map.slots().emplace_back();
        transfer(archive, slot.generation);
        require(slot.generation > 0 && slot.generation < most_generations,
                "a handle without a usable generation");
        transfer(archive, slot.used);
        if (!slot.used) continue;
        Saved saved;
        transfer(archive, saved);
        slot.thing = take(std::move(saved));
    }
}

}  // namespace

void World::save(std::ostream& out) const {
    State& s = *state_;
    s.bring_places(s.used_bodies());
    // Proofs of the last step are about the shapes that bodies had in it.
    if (!s.planned) s.make_plan();
    s.backend->fetch_seen(view_of(std::as_const(s.ids)), view_of(std::as_const(s.seen)));
    StepMemory memory = s.backend->memory();

    ArchiveWriter archive;
    transfer_all(archive, s.settings, s.next_key, s.forgets_sides, s.rest);
    transfer_length(archive, s.meshes.slots().size());
    for (auto& slot : s.meshes.slots()) {
        transfer_all(archive, slot.generation, slot.used);
        if (!slot.used) continue;
        SavedMesh mesh = saved(slot.thing);
        transfer(archive, mesh);
    }
    transfer_length(archive, s.bodies.slots().size());
    for (auto& slot : s.bodies.slots()) {
        transfer_all(archive, slot.generation, slot.used);
        if (!slot.used) continue;
        if (!slot.thing.is_on_device()) {
            transfer(archive, slot.thing);
            continue;
        }
        BodyEntry placed = slot.thing;
        placed.usable = placed.is_placed();
        placed.moved = false;
        transfer(archive, placed);
    }
    std::vector<BodyIdPair> excluded(s.excluded.begin(), s.excluded.end());
    std::vector<std::int32_t> left_out(s.left_out.begin(), s.left_out.end());
    transfer_all(archive, excluded, left_out, memory);

    std::uint64_t first = mark, length = archive.bytes().size(), sum = checksum(archive.bytes());
    std::uint32_t its_version = version;
    ArchiveWriter header;
    transfer_all(header, first, its_version, length, sum);
    out << header.bytes() << archive.bytes();
    if (!out.flush()) throw InputError("a world cannot be written");
}

World World::restore(std::istream& in, std::unique_ptr<Backend> backend) {
    ArchiveReader all(std::string(std::istreambuf_iterator<char>(in), {}));
    std::uint64_t first = 0, length = 0, sum = 0;
    std::uint32_t its_version = 0;
    transfer_all(all, first, its_version);
    require(first == mark, "something else: it is not one");
    if (its_version != version)
        throw InputError("a saved world has version " + std::to_string(its_version) +
                         "; this library reads version " + std::to_string(version));
    transfer_all(all, length, sum);
    require(length == all.left(), "more or less than its header says");
    std::string bytes(length, '\0');
    all.number(bytes.data(), bytes.size());
    require(checksum(bytes) == sum, "damage: its checksum differs");

    ArchiveReader archive(std::move(bytes));
    Settings settings;
    transfer(archive, settings);
    World world(std::move(backend), settings);
    State& s = *world.state_;
    transfer_all(archive, s.next_key, s.forgets_sides, s.rest);
    require(s.next_key <= largest_key, "keys that are used up");
    require(s.rest.resting <= constants::memory_first_rest << constants::memory_doublings,
            "a rest that is too long");
    std::set<std::uint64_t> keys;
    restore_slots<SavedMesh>(archive, s.meshes, [&](SavedMesh mesh) {
        require(mesh.key != 0 && mesh.key < s.next_key && keys.insert(mesh.key).second,
                "a mesh with a wrong key");
        return made_from(std::move(mesh));
    });
    restore_slots<BodyEntry>(archive, s.bodies, [&](BodyEntry body) {
        s.check_restored(body);
        return body;
    });
    std::vector<BodyIdPair> excluded;
    std::vector<std::int32_t> left_out;
    StepMemory memory;
    transfer_all(archive, excluded, left_out, memory);
    for (const BodyIdPair& p : excluded) {
        require(p.a.index < p.b.index, "a pair of one body");
        s.excluded.insert(p);
    }
    s.left_out.insert(left_out.begin(), left_out.end());
    require(archive.left() == 0, "more than there should be");
    s.make_plan();
    std::map<std::uint64_t, MeshView> views;
    for (const auto& slot : s.meshes.slots())
        if (slot.used) views[slot.thing.key] = slot.thing.mesh->view({});
    check(memory, view_of(std::as_const(s.views)), view_of(std::as_const(s.ids)),
          [&](std::uint64_t key) {
              const auto found = views.find(key);
              return found == views.end() ? nullptr : &found->second;
          });
    s.backend->remember(memory);
    return world;
}

void World::State::check_restored(const BodyEntry& body) const {
    const Mesh& mesh = mesh_of(body);
    const bool deforms = body.motion == Motion::deforming;
    require(body.positions.size() == (deforms ? mesh.positions().size() : 0),
            "a body with too many positions or too few");
    require(body.start.size() == body.positions.size() || (!body.moved && body.start.empty()),
            "a body with a start that does not fit its end");
    require(body.seen.empty() || (deforms && body.seen.size() == patch_count(mesh.view({}))),
            "a body seen in another shape");
    require(body.positions_version < next_key, "a body from the future");
    const bool usable = deforms
                            ? is_usable(body.positions) && (!body.moved || is_usable(body.start))
                            : is_usable(body.pose) && (!body.moved || is_usable(body.start_pose));
    require(usable || !body.usable, "a body in a place that is none");
    check_collision(body.motion, mesh, body.collision, "a saved body");
    check_filter(body.filter);
}

}  // namespace pierce
