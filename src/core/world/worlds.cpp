#include <algorithm>
#include <string>
#include <utility>

#include "core/partition/contact_order.hpp"
#include "core/world/world_state.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"

/// Filters, and worlds within a world.
namespace pierce {
namespace {

/// A body like another one, in the same place, as if it had been added there.
BodyEntry copy_of(const BodyEntry& body, std::int32_t world) {
    BodyEntry copy(body.mesh, body.motion, body.pose);
    copy.positions = body.positions;
    copy.collision = body.collision;
    copy.filter = body.filter;
    copy.filter.world = world;
    copy.usable = body.is_placed();
    return copy;
}

}  // namespace

void World::State::check_filter(const Filter& filter) {
    if (filter.world < all_worlds ||
        filter.world >= static_cast<std::int32_t>(constants::most_worlds))
        throw InputError("there is no world " + std::to_string(filter.world) +
                         ": worlds are numbers from 0 to " +
                         std::to_string(constants::most_worlds - 1));
}

void World::State::begin_world(std::int32_t world) {
    if (!left_out.contains(world)) return;
    const bool is_there = std::ranges::any_of(bodies.slots(), [&](const auto& slot) {
        return slot.used && slot.thing.filter.world == world;
    });
    if (!is_there) left_out.erase(world);
}

void World::set_filter(BodyId body, const Filter& filter) {
    State::check_filter(filter);
    BodyEntry& entry = state_->bodies.get(body, "body");
    state_->change();
    state_->begin_world(filter.world);
    entry.filter = filter;
    ++state_->filters_set;
}

const Filter& World::filter_of(BodyId body) const {
    return state_->bodies.get(body, "body").filter;
}

void World::State::check_pair(BodyId a, BodyId b) const {
    bodies.get(a, "body");
    bodies.get(b, "body");
    if (a == b)
        throw InputError(
            "a body and itself are no pair that can be excluded: Collision::self says "
            "whether it meets itself");
}

void World::exclude(BodyId a, BodyId b) {
    state_->check_pair(a, b);
    state_->change();
    state_->excluded.insert({a, b});
}

void World::include(BodyId a, BodyId b) {
    state_->check_pair(a, b);
    state_->change();
    state_->excluded.erase({a, b});
}

std::vector<std::pair<BodyId, BodyId>> World::excluded_pairs() const {
    std::vector<std::pair<BodyId, BodyId>> pairs;
    for (const BodyIdPair& p : state_->excluded)
        if (state_->bodies.contains(p.a) && state_->bodies.contains(p.b))
            pairs.emplace_back(p.a, p.b);
    return pairs;
}

void World::set_pair_filter(PairFilter filter) {
    if (filter && !state_->backend->calls_pair_filters())
        throw InputError("pairs are found on a device, which cannot call a pair filter");
    state_->change();
    state_->pair_filter = std::move(filter);
}

std::vector<std::int32_t> World::worlds() const {
    std::set<std::int32_t> found;
    for (const auto& slot : state_->bodies.slots())
        if (slot.used) found.insert(slot.thing.filter.world);
    found.erase(all_worlds);
    return {found.begin(), found.end()};
}

std::vector<BodyId> World::State::bodies_of(std::int32_t world) {
    const auto& slots = bodies.slots();
    const std::uint64_t now = filters_set + bodies.arrivals();
    if (by_world.at != now) {
        by_world.sorted.clear();
        for (std::uint32_t i = 0; i < slots.size(); ++i)
            if (slots[i].used) by_world.sorted.emplace_back(slots[i].thing.filter.world, i);
        std::ranges::sort(by_world.sorted);
        by_world.at = now;
    }
    std::vector<BodyId> found;
    for (const auto& [its_world, i] : std::ranges::equal_range(
             by_world.sorted, world, {}, [](const auto& listed) { return listed.first; }))
        if (slots[i].used) found.push_back({i, slots[i].generation});
    return found;
}

std::vector<BodyId> World::bodies_of(std::int32_t world) const { return state_->bodies_of(world); }

std::int32_t World::replicate(std::int32_t world, std::uint32_t count) {
    State& s = *state_;
    const std::vector<BodyId> originals = bodies_of(world);
    if (world == all_worlds || originals.empty())
        throw InputError("there is no world " + std::to_string(world) + " to replicate");
    const std::int64_t first = std::int64_t{worlds().back()} + 1;
    if (first + count > constants::most_worlds)
        throw InputError("there would be more than " + std::to_string(constants::most_worlds) +
                         " worlds");
    // Places of bodies that were removed are taken first.
    const auto used = static_cast<std::uint64_t>(
        std::ranges::count_if(s.bodies.slots(), [](const auto& slot) { return slot.used; }));
    const std::uint64_t bodies = std::max<std::uint64_t>(
        s.bodies.slots().size(), used + std::uint64_t{count} * originals.size());
    if (bodies > std::uint64_t{1} << constants::body_bits)
        throw InputError("there would be " + std::to_string(bodies) +
                         " bodies; with worlds there are at most " +
                         std::to_string(std::uint64_t{1} << constants::body_bits));
    std::vector<BodyEntry> copies;
    copies.reserve(originals.size());
    for (BodyId id : originals) copies.push_back(copy_of(s.placed_body(id), world));
    // Pairs that are excluded in the world: which of its bodies, and the other one, which may be
    // in all worlds.
    std::vector<BodyIdPair> within;
    for (const BodyIdPair& p : s.excluded) {
        const auto is_here = [&](BodyId id) { return std::ranges::binary_search(originals, id); };
        if (is_here(p.a) || is_here(p.b)) within.push_back(p);
    }
    s.change();
    std::vector<BodyId> made;
    made.reserve(count * originals.size());
    const auto make = [&](std::int32_t its_world) {
        const std::size_t begin = made.size();
        for (const BodyEntry& copy : copies) {
            BodyEntry body = copy;
            body.filter.world = its_world;
            if (body.motion == Motion::deforming) body.positions_version = s.next_key++;
            made.push_back(s.bodies.add(std::move(body)));
        }
        const auto copy_in_world = [&](BodyId id) {
            const auto at = std::ranges::lower_bound(originals, id);
            return at == originals.end() || *at != id
                       ? id
                       : made[begin + static_cast<std::size_t>(at - originals.begin())];
        };
        for (const BodyIdPair& p : within)
            s.excluded.insert({copy_in_world(p.a), copy_in_world(p.b)});
    };
    try {
        for (std::uint32_t k = 0; k < count; ++k) make(static_cast<std::int32_t>(first + k));
    } catch (...) {
        std::ranges::sort(made);
        const auto is_made = [&](BodyId id) { return std::ranges::binary_search(made, id); };
        std::erase_if(s.excluded,
                      [&](const BodyIdPair& p) { return is_made(p.a) || is_made(p.b); });
        for (const BodyId id : made) s.bodies.take(id, "body");
        throw;
    }
    for (std::uint32_t k = 0; k < count; ++k)
        s.left_out.erase(static_cast<std::int32_t>(first + k));
    return static_cast<std::int32_t>(first);
}

void World::copy_places(std::int32_t from, std::int32_t to) {
    State& s = *state_;
    const auto bodies_in = [&](std::int32_t world) {
        std::vector<BodyId> bodies = bodies_of(world);
        if (bodies.empty()) throw InputError("there is no world " + std::to_string(world));
        return bodies;
    };
    const std::vector<BodyId> there = bodies_in(from), here = bodies_in(to);
    const auto is_alike = [&](BodyId a, BodyId b) {
        const BodyEntry &one = s.bodies.get(a, "body"), &other = s.bodies.get(b, "body");
        return one.motion == other.motion && one.mesh == other.mesh;
    };
    if (!std::ranges::equal(there, here, is_alike))
        throw InputError("worlds " + std::to_string(from) + " and " + std::to_string(to) +
                         " do not have the same bodies");
    std::vector<BodyEntry> copies;
    copies.reserve(there.size());
    for (BodyId id : there) copies.push_back(copy_of(s.placed_body(id), to));
    for (std::size_t i = 0; i < here.size(); ++i) {
        BodyEntry& body = s.bodies.get(here[i], "body");
        s.note_change(here[i]);
        body.pose = body.start_pose = copies[i].pose;
        body.start = copies[i].positions;
        body.positions = std::move(copies[i].positions);
        body.leave_device();
        body.usable = copies[i].usable;
        body.moved = false;
        if (body.motion == Motion::deforming) body.positions_version = s.next_key++;
    }
}

void World::remove_world(std::int32_t world) {
    if (world == all_worlds) throw InputError("bodies of all worlds are removed one by one");
    for (BodyId body : bodies_of(world)) remove_body(body);
}

void World::set_world_active(std::int32_t world, bool active) {
    const std::vector<BodyId> bodies = bodies_of(world);
    if (world == all_worlds || bodies.empty())
        throw InputError("there is no world " + std::to_string(world));
    if (active)
        state_->left_out.erase(world);
    else
        state_->left_out.insert(world);
    for (BodyId body : bodies) state_->note_change(body);
}

WorldOffsets World::world_offsets() const {
    const State& s = *state_;
    s.check_stepped("world_offsets");
    WorldOffsets offsets{s.worlds, {}, {}};
    const std::span<const Contact> all = contacts();
    const View<const BodyView> views = view_of(s.views);
    const auto sheets = std::ranges::find_if_not(
        all, [&](const Contact& c) { return is_by_ray(c, views); });
    const auto place_of = [&](const Contact& c) {
        return std::min(s.views[c.a.index].world_place, s.views[c.b.index].world_place);
    };
    const auto count = [&](std::span<const Contact> part, std::size_t before) {
        std::vector<std::uint32_t> begins;
        for (std::uint32_t place = 0; place <= s.worlds.size(); ++place) {
            const auto at = std::ranges::lower_bound(part, place, {}, place_of);
            begins.push_back(static_cast<std::uint32_t>(before) +
                             static_cast<std::uint32_t>(at - part.begin()));
        }
        return begins;
    };
    offsets.solids = count({all.begin(), sheets}, 0);
    offsets.sheets = count({sheets, all.end()}, static_cast<std::size_t>(sheets - all.begin()));
    return offsets;
}

}  // namespace pierce
