#include <algorithm>
#include <span>
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
    std::string mine;
    together([&] {
        make_lists();
        news.kinds = {};
        std::set<std::int32_t> worlds;
        for (const std::uint32_t b : own) {
            news.kinds.add(inside.kinds_of(entry(b)));
            worlds.insert(entry(b).filter.world);
        }
        if (!left_out.empty()) news.worlds.assign(worlds.begin(), worlds.end());
        mine = to_bytes(news);
    });
    const std::vector<std::string> all = comm.all_gather(mine);
    const std::vector<BodyId> added = std::exchange(news, {}).added;
    has_news = false;
    heard.clear();
    try {
        together([&] { take_in_news(all); });
    } catch (...) {
        // As long as two ranks have the same body, every step fails.
        news.added = added;
        heard.insert(added.begin(), added.end());
        has_news = true;
        throw;
    }
}

void World::State::take_in_news(const std::vector<std::string>& all) {
    std::vector<News> news_of;
    for (const std::string& bytes : all) news_of.push_back(from_bytes<News>(bytes));
    const std::string conflict = conflict_in(news_of);
    BodyKinds elsewhere;
    std::set<std::int32_t> used;
    for (std::uint32_t from = 0; from < news_of.size(); ++from) {
        const News& its = news_of[from];
        for (const BodyIdPair& pair : its.included) excluded.erase(pair);
        excluded.insert(its.excluded.begin(), its.excluded.end());
        used.insert(its.worlds.begin(), its.worlds.end());
        for (const BodyId body : its.removed) {
            std::erase_if(excluded,
                          [&](const BodyIdPair& pair) { return pair.a == body || pair.b == body; });
            if (from != rank() && !is_own(body)) inside.bodies.retire(body);
        }
        if (from != rank()) elsewhere.add(its.kinds);
    }
    // Other bodies are elsewhere, and some pairs may not be wanted.
    inside.elsewhere = elsewhere;
    inside.change();
    drop_away();
    settle_worlds(used);
    exclude_pairs();
    if (!conflict.empty()) throw InputError(conflict);
}

std::string World::State::conflict_in(std::span<const News> news_of) const {
    const auto on = [](std::uint32_t its) { return " on rank " + std::to_string(its); };
    std::map<std::uint32_t, std::uint32_t> adders;  // by number
    std::map<BodyId, std::uint32_t> removers;
    for (std::uint32_t from = 0; from < news_of.size(); ++from)
        for (const BodyId body : news_of[from].removed) removers.emplace(body, from);
    std::string conflict;
    for (std::uint32_t from = 0; from < news_of.size(); ++from)
        for (const BodyId body : news_of[from].added) {
            const auto [first, is_new] = adders.emplace(body.index, from);
            const auto remover = removers.find(body);
            const std::string name = "body " + std::to_string(body.index);
            if (!is_new)
                conflict = name + " was added" + on(first->second) + " and" + on(from);
            else if (from != rank() && belongs_to(body.index, rank()))
                conflict = name + " was added" + on(rank()) + " and" + on(from);
            else if (remover != removers.end() && remover->second != from)
                // Others would take the new one for the one that they know.
                conflict = name + " was removed" + on(remover->second) + " and added" + on(from) +
                           " in the same step";
        }
    return conflict;
}

void World::State::settle_worlds(const std::set<std::int32_t>& used) {
    std::erase_if(left_out, [&](std::int32_t world) { return !used.contains(world); });
    inside.left_out = left_out;
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
    std::vector<Box> boxes;
    std::vector<std::uint32_t> of_ranks;
    for (std::uint32_t other = 0; other < all.size(); ++other) {
        work.push_back(all[other].work);
        if (other == rank()) continue;
        boxes.insert(boxes.end(), all[other].reach, all[other].reach + all[other].box_count);
        of_ranks.resize(boxes.size(), other);
    }
    near_ranks = NearRanks(std::move(boxes), std::move(of_ranks));
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
            reach[b] = view.active && !entry(b).is_on_device()
                           ? reach_on_host(view, inside.plan.settings)
                           : Box{};
    }
    measure_on_device();
    Summary mine;
    for (const BodyView& view : inside.views)
        if (view.active)
            mine.work += (view.part == rank() ? 1 : constants::ghost_work) *
                         view.mesh.triangles.size;

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
        if (mine.box_count < Summary::most_boxes)
            mine.reach[mine.box_count++] = box;
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
    if (slot.thing.is_on_device()) {
        body.entry.usable = slot.thing.is_placed();
        body.entry.moved = slot.thing.device_start != nullptr;
        body.entry.leave_device();
    }
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

std::vector<std::vector<NearBody>> World::State::near_bodies() const {
    std::vector<std::vector<NearBody>> near(others.size());
    const double spare = constants::spare_reach * mean_extent;
    for (const std::uint32_t b : own) near_ranks.note(b, reach[b], spare, near);
    return near;
}

/// True for a mesh that was made here, or that a body of this rank has. What is only here as other
/// ranks have sent it need not be known there: two ranks could keep it for each other for ever.
bool World::State::has_mesh(std::uint64_t key) const {
    const auto known = known_meshes.find(key);
    const MeshId sent = known != known_meshes.end() ? known->second.here : MeshId{};
    const auto& slots = inside.meshes.slots();
    for (std::uint32_t m = 0; m < slots.size(); ++m)
        if (slots[m].used && slots[m].thing.key == key && MeshId{m, slots[m].generation} != sent)
            return true;
    return sent && std::ranges::any_of(own, [&](std::uint32_t b) {
               return inside.bodies.slots()[b].thing.mesh == sent;
           });
}

GhostMessage World::State::message_to(std::uint32_t to, const std::vector<NearBody>& near) {
    OtherRank& other = others[to];
    GhostMessage message;
    for (const std::uint32_t b : removed)
        if (std::erase(other.has, b) > 0) message.left.push_back(b);

    // Pairs of two moving bodies belong to the lower one of their ranks.
    const auto may_be_pair = [&](std::uint32_t b) { return to < rank() || !is_moving(b); };
    // Where ghosts come at all, those come, too, that are nearly near: a new ghost costs a plan.
    const bool comes = std::ranges::any_of(near, [&](const NearBody& body) {
        return body.nearness == Nearness::near && may_be_pair(body.number) &&
               !std::ranges::binary_search(other.has, body.number);
    });
    std::vector<std::uint32_t> has;
    const auto send_whole = [&](std::uint32_t b) {
        add_mesh_to(message.meshes, b, other.meshes);
        message.bodies.push_back(whole(b, tells_seen() ? &to_remember() : nullptr));
    };
    auto had = other.has.begin();
    const auto leave_until = [&](std::uint32_t number) {
        for (; had != other.has.end() && *had < number; ++had) message.left.push_back(*had);
    };
    for (const auto& [b, nearness] : near) {
        leave_until(b);
        if (had != other.has.end() && *had == b) {
            ++had;
            has.push_back(b);
            if (changed_bodies.contains(b))
                send_whole(b);
            else if (refreshed_now[b] || entry(b).is_on_device())
                add_moved(message.moved, b);
        } else if (comes && nearness >= Nearness::nearly && may_be_pair(b)) {
            has.push_back(b);
            send_whole(b);
        }
    }
    leave_until(UINT32_MAX);
    other.has = std::move(has);
    other.got.insert(other.meshes.begin(), other.meshes.end());
    for (auto key = other.got.begin(); key != other.got.end();) {
        const bool is_kept = has_mesh(*key);
        if (!is_kept) {
            message.forgotten.push_back(*key);
            other.meshes.erase(*key);
        }
        key = is_kept ? std::next(key) : other.got.erase(key);
    }
    return message;
}

void World::State::add_moved(std::vector<MovedBody>& all, std::uint32_t b) const {
    const BodyEntry& body = inside.bodies.slots()[b].thing;
    const bool deforms = body.motion == Motion::deforming, there = body.is_on_device();
    if (!there && (deforms ? body.positions_version == told[b].positions_version
                           : !body.moved && are_identical(body.pose, told[b].pose)))
        return;
    MovedBody& moved = all.emplace_back();
    moved.number = b;
    moved.tells_start = there ? body.device_start != nullptr : inside.plan.sheets && body.moved;
    moved.pose = body.pose;
    moved.positions = body.positions;
    if (moved.tells_start) {
        moved.start_pose = body.start_pose;
        moved.start = body.start;
    }
}

std::vector<std::string> World::State::messages() {
    std::vector<std::string> to(others.size());
    together([&] {
        refreshed_now.assign(inside.views.size(), 0);
        for (const std::uint32_t b : inside.refreshed) refreshed_now[b] = 1;
        std::vector<std::vector<NearBody>> near = near_bodies();
        bring_places(near);
        for (std::uint32_t other = 0; other < others.size(); ++other) {
            if (other == rank()) continue;
            GhostMessage message = message_to(other, near[other]);
            if (!message.empty()) to[other] = to_bytes(message);
        }
        for (const std::uint32_t b : inside.refreshed)
            told[b] = {entry(b).positions_version, entry(b).pose};
        changed_bodies.clear();
        removed.clear();
    });
    return to;
}

}  // namespace pierce::mpi
