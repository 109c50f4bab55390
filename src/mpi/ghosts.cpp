#include <algorithm>
#include <utility>

#include "core/partition/body_reach.hpp"
#include "core/partition/space_partition.hpp"
#include "mpi/world_state.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"

/// The parts of a step before pairs are looked at: what is new, who reaches where, and which bodies
/// become ghosts of which rank.
namespace pierce::mpi {
namespace {

/// What every rank says first.
struct Flags {
    bool has_news = false, forgets_sides = false;
};

}  // namespace

void World::State::agree_on_news() {
    bool any_news = false;
    for (const Flags& flags : comm.all_gather(Flags{has_news, forgets_sides})) {
        any_news = any_news || flags.has_news;
        forgets_sides = forgets_sides || flags.forgets_sides;
    }
    if (!any_news) return;
    make_lists();
    news.kinds = {};
    for (const std::uint32_t b : own) news.kinds.add(inside.kinds_of(entry(b)));
    const std::vector<std::string> all = comm.all_gather(to_bytes(news));
    const std::vector<BodyId> added = std::exchange(news, {}).added;
    has_news = false;
    try {
        together([&] { take_in_news(all); });
    } catch (...) {
        // As long as two ranks have the same body, every step fails.
        news.added = added;
        has_news = true;
        throw;
    }
}

void World::State::take_in_news(const std::vector<std::string>& all) {
    BodyKinds elsewhere;
    std::string conflict;
    std::map<std::uint32_t, std::uint32_t> adders;
    for (std::uint32_t from = 0; from < all.size(); ++from) {
        const News its = from_bytes<News>(all[from]);
        for (const BodyIdPair& pair : its.included) excluded.erase(pair);
        excluded.insert(its.excluded.begin(), its.excluded.end());
        for (const BodyId body : its.removed) {
            std::erase_if(excluded,
                          [&](const BodyIdPair& pair) { return pair.a == body || pair.b == body; });
            if (from != rank() && !is_own(body)) inside.bodies.retire(body);
        }
        if (from != rank()) elsewhere.add(its.kinds);
        for (const BodyId body : its.added) {
            const auto [first, is_new] = adders.emplace(body.index, from);
            const bool taken = from != rank() && belongs_to(body.index, rank());
            if (is_new && !taken) continue;
            conflict = "body " + std::to_string(body.index) + " was added on rank " +
                       std::to_string(is_new ? rank() : first->second) + " and on rank " +
                       std::to_string(from);
        }
    }
    // Other bodies are elsewhere, and some pairs may not be wanted.
    inside.elsewhere = elsewhere;
    inside.change();
    exclude_pairs();
    if (!conflict.empty()) throw InputError(conflict);
}

void World::State::make_lists() {
    if (!own_changed) return;
    own_changed = false;
    own.clear();
    const auto& slots = inside.bodies.slots();
    for (std::uint32_t b = 0; b < slots.size(); ++b)
        if (belongs_to(b, rank())) own.push_back(b);
    cell.clear();
}

/// Finds out what this rank's bodies reach, and tells all.
void World::State::look_around() {
    Summary mine;
    const std::exception_ptr failure = failure_of([&] { mine = summary(); });
    mine.failed = failure != nullptr;
    const std::vector<Summary> all = comm.all_gather(mine);
    if (std::ranges::any_of(all, &Summary::failed)) fail(failure);
    work.clear();
    for (std::size_t other = 0; other < all.size(); ++other) {
        work.push_back(all[other].work);
        others[other].reach = Region({all[other].reach, all[other].reach + all[other].boxes});
    }
}

Summary World::State::summary() {
    make_lists();
    inside.refresh_views();
    const std::size_t slots = inside.views.size();
    reach.resize(slots);
    told.resize(slots);
    for (const std::uint32_t b : inside.refreshed) {
        const BodyView& view = inside.views[b];
        if (view.part == rank())
            reach[b] = view.active ? reach_on_host(view, inside.plan.settings) : Box{};
    }
    Summary mine;
    for (const BodyView& view : inside.views)
        if (view.active) mine.work += view.mesh.triangles.size;

    const auto region = [&] {
        Region made(constants::part_cells, mean_extent);
        for (std::size_t k = 0; k < own.size(); ++k)
            if (is_moving(own[k]) && !reach[own[k]].empty()) made.add(cell[k], reach[own[k]]);
        made.close(0);
        return made;
    };
    const auto extent_of = [](const std::vector<Box>& boxes) {
        double sum = 0;
        for (const Box& box : boxes) sum += box.extent();
        return sum;
    };
    std::vector<Box> boxes;
    if (cell.size() == own.size()) boxes = region().boxes();
    if (cell.size() != own.size() || extent_of(boxes) > constants::uneven_parts * cells_extent) {
        std::vector<WeightedPoint> places;
        places.reserve(own.size());
        Vec3d last;
        mean_extent = 0;
        for (const std::uint32_t b : own) {
            if (!reach[b].empty()) last = reach[b].center();
            places.push_back({last, static_cast<double>(inside.views[b].mesh.triangles.size)});
            mean_extent += reach[b].extent() / static_cast<double>(own.size());
        }
        cell = divide_space(places, std::vector<double>(constants::part_cells, 1.0));
        boxes = region().boxes();
        cells_extent = extent_of(boxes);
    }
    for (const Box& box : boxes) {
        if (mine.boxes < Summary::most_boxes)
            mine.reach[mine.boxes++] = box;
        else
            mine.reach[Summary::most_boxes - 1].extend(box);
    }
    return mine;
}

WholeBody World::State::whole(std::uint32_t b, const StepMemory* memory) const {
    const auto& slot = inside.bodies.slots()[b];
    WholeBody body{.id = {b, slot.generation},
                   .mesh_key = inside.meshes.get(slot.thing.mesh, "mesh").key,
                   .entry = slot.thing,
                   .in_last = {}};
    if (memory == nullptr)
        body.entry.seen.clear();
    else if (b < memory->bodies.size())
        body.in_last = memory->bodies[b];
    return body;
}

void World::State::add_mesh_to(std::vector<SavedMesh>& meshes, std::uint32_t b,
                               std::set<std::uint64_t>& has) const {
    const MeshEntry& mesh = inside.meshes.get(inside.bodies.slots()[b].thing.mesh, "mesh");
    if (has.insert(mesh.key).second) meshes.push_back(saved(mesh));
}

GhostMessage World::State::message_to(std::uint32_t to) {
    OtherRank& other = others[to];
    other.has.resize(inside.views.size());
    GhostMessage message;
    for (const std::uint32_t b : removed)
        if (std::exchange(other.has[b], std::uint8_t{0})) message.left.push_back(b);

    // Pairs of two moving bodies belong to the lower one of their ranks.
    const auto may_be_pair = [&](std::uint32_t b) { return to < rank() || !is_moving(b); };
    const auto meets = [&](std::uint32_t b, double more) {
        return !reach[b].empty() && other.reach.meets(reach[b].inflated(more));
    };
    // Where ghosts come at all, those come, too, that are nearly near: a new ghost costs a plan.
    bool comes = false;
    for (const std::uint32_t b : own)
        comes = comes || (may_be_pair(b) && !other.has[b] && meets(b, 0));
    const double spare = constants::spare_reach * mean_extent;
    const auto send_whole = [&](std::uint32_t b) {
        add_mesh_to(message.meshes, b, other.meshes);
        message.bodies.push_back(whole(b, tells_seen() ? &to_remember() : nullptr));
        other.has[b] = 1;
    };
    for (const std::uint32_t b : own) {
        if (!other.has[b]) {
            if (comes && may_be_pair(b) && meets(b, spare)) send_whole(b);
        } else if (!meets(b, 2 * spare)) {
            other.has[b] = 0;
            message.left.push_back(b);
        } else if (changed_bodies.contains(b)) {
            send_whole(b);
        }
    }
    for (const std::uint32_t b : inside.refreshed) {
        const BodyEntry& body = entry(b);
        if (body.part != rank() || !other.has[b] || changed_bodies.contains(b)) continue;
        const bool deforms = body.motion == Motion::deforming;
        if (deforms ? body.positions_version == told[b].positions_version
                    : !body.moved && are_identical(body.pose, told[b].pose))
            continue;
        MovedBody moved;
        moved.number = b;
        moved.tells_start = inside.plan.sheets && body.moved;
        moved.pose = body.pose;
        moved.positions = body.positions;
        if (moved.tells_start) {
            moved.start_pose = body.start_pose;
            moved.start = body.start;
        }
        message.moved.push_back(std::move(moved));
    }
    for (auto key = other.meshes.begin(); key != other.meshes.end();) {
        const bool is_kept = std::ranges::any_of(inside.meshes.slots(), [&](const auto& slot) {
            return slot.used && slot.thing.key == *key;
        });
        if (!is_kept) message.forgotten.push_back(*key);
        key = is_kept ? std::next(key) : other.meshes.erase(key);
    }
    return message;
}

std::vector<std::string> World::State::messages() {
    std::vector<std::string> to(others.size());
    together([&] {
        for (std::uint32_t other = 0; other < others.size(); ++other) {
            if (other == rank()) continue;
            GhostMessage message = message_to(other);
            if (!message.empty()) to[other] = to_bytes(message);
        }
        for (const std::uint32_t b : inside.refreshed)
            told[b] = {entry(b).positions_version, entry(b).pose};
        changed_bodies.clear();
        removed.clear();
    });
    return to;
}

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
        if (!known_meshes.contains(key))
            known_meshes[key] = inside.meshes.add(made_from(std::move(mesh)));
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
    auto& slots = inside.bodies.slots();
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
    // A new plan is made in any case.
    for (std::uint32_t b = 0; b < slots.size(); ++b)
        if (slots[b].used && slots[b].thing.away) {
            inside.bodies.take(id(b), "body");
            inside.change();
        }
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
