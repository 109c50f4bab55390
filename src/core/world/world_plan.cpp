#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "core/base/for_now.hpp"
#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/patch.hpp"
#include "core/world/world_state.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"

namespace pierce {

void World::State::list_blocks() {
    block_items.clear();
    ranges.clear();
    for (std::uint32_t body = 0; body < views.size(); ++body) {
        if (!ids[body] || views[body].motion != Motion::deforming) continue;
        BlockRange range{body, static_cast<std::uint32_t>(block_items.size()), 0};
        for (std::uint32_t b = 0; b < views[body].blocks.size; ++b)
            block_items.push_back({body, b});
        range.last = static_cast<std::uint32_t>(block_items.size());
        ranges.push_back(range);
    }
}

void World::State::list_nodes() {
    node_items.clear();
    for (std::uint32_t level = 0; level < BoxLevels::most; ++level) {
        level_begin[level] = static_cast<std::uint32_t>(node_items.size());
        for (std::uint32_t body = 0; body < views.size(); ++body) {
            if (box_nodes[body].size == 0) continue;
            const BoxLevels levels(views[body].mesh.triangles.size);
            if (level >= levels.count) continue;
            for (std::uint32_t n = levels.begin[level]; n < levels.begin[level + 1]; ++n)
                node_items.push_back({body, n});
        }
    }
    level_begin[BoxLevels::most] = static_cast<std::uint32_t>(node_items.size());
}

void World::State::check_collision(Motion motion, const Mesh& mesh, const Collision& collision,
                                   const std::string& name) const {
    if (collision.self > SelfCollision::published)
        throw InputError(name + " meets itself in a way without a meaning");
    const bool asks = collision.sheet || collision.self != SelfCollision::off;
    if (asks && motion != Motion::deforming)
        throw InputError(name + " does not deform: it meets neither itself nor others as a sheet");
    if (!(collision.thickness >= 0) || collision.thickness > constants::largest_coordinate)
        throw InputError(name + " needs a thickness that is neither negative nor beyond 2^60");
    if (!(std::fabs(collision.margin) <= constants::largest_coordinate))
        throw InputError(name + " needs a margin that is not beyond 2^60");
    if (!collision.sheet && collision.thickness > 0)
        throw InputError(name + " has a thickness but is no sheet");
    if (collision.sheet && mesh.inside().rule == Inside::winding)
        throw InputError(name + " cannot be a sheet: the holes of mesh '" + mesh.name() +
                         "' are closed; add the mesh with Inside::none");
    if (!collision.sheet && asks && !mesh.inside().exists())
        throw InputError(name + " has no inside: it can meet itself only as a sheet");
    if (!collision.sheet && asks && collision.self != SelfCollision::on)
        throw InputError(name + " is a solid: rays along velocities are for sheets");
}

void World::State::change_mesh(BodyId body) {
    check_not_planning();
    if (planned) reshaped.emplace();
    if (reshaped) reshaped->push_back(body.index);
    planned = stepped = still = false;
}

namespace {

/// What the steps of a plan read of a body's mesh.
MeshNeeds needs_of(const Plan& plan, Motion motion) {
    if (!plan.casts_rays) return {};
    const bool own_exits = !plan.settings.inside_is_contact();
    return {.clearance = true,
            .rings = plan.remembers() || plan.misses_no_overlap() || plan.reprojects,
            .slabs = plan.misses_no_overlap() && motion != Motion::deforming,
            .stars = plan.traces_own_exits || plan.meets_itself,
            .own_exits = own_exits && motion != Motion::deforming};
}

void list_stages(Plan& plan) {
    plan.stages.clear();
    for (const StageInfo& stage : stage_table())
        if (stage.needed(plan)) plan.stages.push_back(stage.id);
}

}  // namespace

void World::State::arrange_worlds() {
    excluded_pairs.clear();
    const auto exists = [&](BodyId id) { return id.index < ids.size() && ids[id.index] == id; };
    std::erase_if(excluded, [&](const BodyIdPair& p) { return !exists(p.a) || !exists(p.b); });
    for (const BodyIdPair& p : excluded) excluded_pairs.push_back({p.a.index, p.b.index});

    std::set<std::int32_t> used;
    for (const BodyView& view : views) used.insert(view.filter.world);
    used.erase(all_worlds);
    worlds.assign(used.begin(), used.end());
    // A world may have bodies elsewhere.
    if (!elsewhere.worlds)
        std::erase_if(left_out, [&](std::int32_t world) { return !used.contains(world); });
    world_begins.clear();
    plan.worlds = static_cast<std::uint32_t>(worlds.size());
    plan.excluded_pairs = static_cast<std::uint32_t>(excluded_pairs.size());
    if (worlds.empty() && !elsewhere.worlds) return;
    if (views.size() > std::size_t{1} << constants::body_bits)
        throw InputError("a world with worlds has at most " +
                         std::to_string(std::size_t{1} << constants::body_bits) + " bodies");
    world_begins.assign(worlds.size() + 2, 0);
    for (BodyView& view : views) {
        const auto at = std::ranges::lower_bound(worlds, view.filter.world);
        view.world_place = view.filter.world == all_worlds
                               ? plan.worlds
                               : static_cast<std::uint32_t>(at - worlds.begin());
        ++world_begins[view.world_place + 1];
    }
    std::partial_sum(world_begins.begin(), world_begins.end(), world_begins.begin());
}

double World::State::margin_of(const BodyEntry& body) const {
    if (body.collision.sheet) return 0;
    return body.collision.margin < 0 ? settings.margin : body.collision.margin;
}

void BodyKinds::add(const BodyKinds& other) {
    solids = solids || other.solids;
    deforming = deforming || other.deforming;
    margins = margins || other.margins;
    sheets = sheets || other.sheets;
    velocity_rays = velocity_rays || other.velocity_rays;
    meets_itself = meets_itself || other.meets_itself;
    worlds = worlds || other.worlds;
    feature_bits = std::max(feature_bits, other.feature_bits);
}

BodyKinds World::State::kinds_of(const BodyEntry& body) const {
    const Mesh& mesh = mesh_of(body);
    const MeshView view = mesh.view({});
    const bool meets_itself = body.collision.self != SelfCollision::off;
    BodyKinds kinds;
    kinds.solids = !body.collision.sheet && mesh.inside().exists();
    kinds.deforming = body.motion == Motion::deforming;
    kinds.margins = margin_of(body) > 0;
    kinds.sheets = body.collision.sheet;
    kinds.velocity_rays = body.collision.sheet && meets_itself &&
                          body.collision.self != SelfCollision::on;
    kinds.meets_itself = !body.collision.sheet && meets_itself;
    kinds.worlds = body.filter.world != all_worlds;
    kinds.feature_bits = static_cast<std::uint32_t>(
        std::bit_width(std::max({view.positions.size, view.edges.size, view.triangles.size})));
    return kinds;
}

/// Which stages steps need for the bodies that there are, and in which settings.
void World::State::decide_plan() {
    plan = {};
    plan.revision = next_key++;
    plan.settings = settings;
    BodyKinds kinds = elsewhere;
    for (const auto& slot : bodies.slots())
        if (slot.used && !slot.thing.away) kinds.add(kinds_of(slot.thing));
    plan.sheets = kinds.sheets;
    plan.velocity_rays = kinds.velocity_rays;
    plan.meets_itself = kinds.meets_itself;
    plan.feature_bits = kinds.feature_bits;
    plan.casts_rays = kinds.solids || plan.velocity_rays;
    if (!kinds.solids) plan.settings.coverage = Coverage::vertices;
    plan.margins = kinds.margins && kinds.solids;
    // A sheet's vertex inside a solid leaves by the closest point, as the sheet's normals say
    // nothing about the way out.
    plan.reprojects = plan.casts_rays && (settings.reproject || (plan.sheets && kinds.solids));
    // Where no rays are cast, there is nothing to remember of them.
    if (!plan.casts_rays) plan.settings.temporal = Temporal::off;
    if (plan.settings.temporal == Temporal::certified && !backend->certificates_pay()) {
        plan.settings.temporal = Temporal::off;
        plan.notes.push_back(
            "Temporal::certified runs as Temporal::off: on this backend tracing a ray costs less "
            "than the proof that it is needless; the contacts are the same");
    }

    plan.traces_own_exits = plan.casts_rays && !plan.settings.inside_is_contact() &&
                            (kinds.deforming || plan.is_complete());
    describe_bodies();
    plan.measures_deformation = plan.deforming_bodies > 0;
}

/// What follows from the plan as it is decided.
void World::State::finish_plan() {
    list_stages(plan);
    resting_plan = plan;
    resting_plan.settings.temporal = Temporal::off;
    list_stages(resting_plan);
}

/// What steps read of a body's mesh, and where they write what they measure of the body.
void World::State::make_view(std::uint32_t i) {
    auto& slots = bodies.slots();
    BodyView& view = views[i];
    view.active = false;
    if (!slots[i].used) return;
    BodyEntry& body = slots[i].thing;
    const MeshEntry entry = meshes.get(body.mesh, "mesh");  // a callback may add meshes
    ids[i] = {i, slots[i].generation};
    view.mesh = entry.mesh->view(needs_of(plan, body.motion));
    view.mesh_key = entry.key;
    view.motion = body.motion;
    view.part = body.part;
    view.collision = body.collision;
    view.filter = body.filter;
    view.margin = margin_of(body);
    view.range = settings.open_body_range * view.mesh.mean_edge_length;
    // Nothing is deeper than what is furthest away.
    view.memory = plan.sheets ? std::min(view.range, 2 * constants::largest_coordinate) : 0.0;
    view.fit_box = view.mesh.box;
    view.touch = constants::touch_tolerance * view.fit_box.extent();
    if (body.motion == Motion::deforming) {
        place_vertices(i);
        body.blocks.resize(block_count(view.mesh));
        body.patches.resize(patch_count(view.mesh));
        view.blocks = blocks[i] = view_of(body.blocks);
        view.patches = patches[i] = view_of(body.patches);
        if (plan.needs_boxes() && view.is_solid()) {
            body.box_nodes.resize(view.mesh.box_nodes.size);
            view.box_nodes = box_nodes[i] = view_of(body.box_nodes);
        }
        if (plan.remembers()) {
            body.seen.resize(patch_count(view.mesh));
            seen[i] = view_of(body.seen);
        }
    } else {
        view.positions = view.mesh.positions;
        view.blocks = view.mesh.blocks;
        view.patches = view.mesh.patches;
        view.box_nodes = view.mesh.box_nodes;
    }
}

void World::State::check_not_planning() const {
    if (planning) throw InputError("a world is used by the progress callback of one of its meshes");
}

void World::State::make_plan() {
    check_not_planning();
    const ForNow now(planning, true);
    const std::optional<std::vector<std::uint32_t>> some = std::exchange(reshaped, std::nullopt);
    if (some && adapt_plan(*some)) {
        planned = true;
        return;
    }
    decide_plan();
    const std::size_t slots = bodies.slots().size();
    views.assign(slots, {});
    ids.assign(slots, {});
    blocks.assign(slots, {});
    patches.assign(slots, {});
    box_nodes.assign(slots, {});
    seen.assign(slots, {});
    for (std::uint32_t i = 0; i < slots; ++i) make_view(i);
    list_blocks();
    list_nodes();
    arrange_worlds();
    finish_plan();
    not_seen.assign(slots, {});
    planned = true;
    unusable.clear();
    changed.clear();
    for (std::uint32_t i = 0; i < ids.size(); ++i)
        if (ids[i]) changed.push_back(i);
}

bool World::State::adapt_plan(std::span<const std::uint32_t> some) {
    const Plan before = std::exchange(plan, {});
    decide_plan();
    plan.worlds = before.worlds;
    plan.excluded_pairs = before.excluded_pairs;
    finish_plan();
    // Steps that are alike need the same of every mesh, so the views of all other bodies hold.
    if (!before.steps_like(plan)) return false;
    bool same_sizes = true;
    for (const std::uint32_t i : some) {
        const std::uint32_t world_place = views[i].world_place;
        const std::array had{blocks[i].size, box_nodes[i].size};
        views[i] = {};
        blocks[i] = {};
        patches[i] = {};
        box_nodes[i] = {};
        seen[i] = {};
        make_view(i);
        views[i].world_place = world_place;
        same_sizes = same_sizes && had == std::array{blocks[i].size, box_nodes[i].size};
        changed.push_back(i);
    }
    if (!same_sizes) {
        list_blocks();
        list_nodes();
    }
    return true;
}

void World::State::refresh_views() {
    if (!planned) make_plan();
    refreshed = changed;
    // Where a motion has ended, the step begins where it ends.
    if (plan.sheets) refreshed.insert(refreshed.end(), changed_last.begin(), changed_last.end());
    std::ranges::sort(refreshed);
    refreshed.erase(std::ranges::unique(refreshed).begin(), refreshed.end());
    std::erase_if(refreshed, [&](std::uint32_t i) { return !(i < ids.size()) || !ids[i]; });
    for (const std::uint32_t i : refreshed) refresh_view(i);
    if (!unusable.empty()) stats.status |= body_excluded;
    stats.excluded_bodies = static_cast<std::uint32_t>(unusable.size());
}

void World::State::refresh_view(std::uint32_t i) {
    BodyEntry& body = bodies.slots()[i].thing;
    views[i].active = body.usable && !body.away && !left_out.contains(body.filter.world);
    if (body.usable)
        unusable.erase(i);
    else
        unusable.insert(i);
    if (body.motion == Motion::deforming) {
        if (plan.sheets && body.device_positions != nullptr && body.device_start == nullptr)
            throw InputError("body " + std::to_string(i) +
                             " needs positions in device memory for both ends of the step");
        if (plan.sheets && !body.moved && body.device_positions == nullptr &&
            body.start != body.positions) {
            body.start = body.positions;
            body.positions_version = next_key++;
        }
        place_vertices(i);
        views[i].positions_version = body.positions_version;
        views[i].device_positions = body.device_positions;
        views[i].device_start = body.device_start;
        return;
    }
    if (plan.sheets && body.device_pose.exists())
        throw InputError("body " + std::to_string(i) +
                         " has its pose in device memory, where sheets cannot have it");
    views[i].device_pose = body.device_pose;
    if (body.usable) views[i].fit = views[i].space = frame_of(body.pose);
    views[i].start_space = plan.sheets && body.moved ? frame_of(body.start_pose) : views[i].space;
}

void World::State::place_vertices(std::uint32_t index) {
    BodyEntry& body = bodies.slots()[index].thing;
    if (plan.sheets) body.start.resize(body.positions.size());
    views[index].positions = view_of(std::as_const(body.positions));
    views[index].start = plan.sheets ? view_of(std::as_const(body.start)) : View<const Vec3f>{};
}

}  // namespace pierce
