#include "core/partition/part_scene.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace pierce {
namespace {

/// True if some body is in the first set and not in the second one. Looks at all of them without a
/// branch, sixteen or more at once.
bool has_others(const BodySet& bodies, const BodySet& known) {
    std::uint8_t others = 0;
    for (std::size_t b = 0; b < bodies.size(); ++b)
        others = static_cast<std::uint8_t>(others | (bodies[b] & ~known[b]));
    return others != 0;
}

}  // namespace

void PartScene::show(const Scene& whole, const Partition& partition, bool anew) {
    const BodySet& near = partition.near(part_);
    if (!anew && has(near)) return update(whole, {whole.changed.data, whole.changed.size}, near);
    settle(whole, partition, partition.residents(part_));
    std::vector<std::uint32_t> all(whole.bodies.size);
    std::iota(all.begin(), all.end(), 0u);
    update(whole, all, near);
}

void PartScene::settle(const Scene& whole, const Partition& partition, BodySet resident) {
    ++revision_;
    resident_ = std::move(resident);
    const std::size_t count = whole.bodies.size;
    BodyView nobody;
    nobody.active = false;
    nobody.world_place = whole.world_begins.size < 2 ? 0 : whole.world_begins.size - 2;
    views_.assign(count, nobody);
    ids_.assign(count, {});
    near_.assign(count, 0);
    own_.assign(count, 0);
    shapes_.resize(count);
    blocks_.assign(count, {});
    patches_.assign(count, {});
    seen_.assign(count, {});
    box_nodes_.assign(count, {});
    for (std::uint32_t b = 0; b < count; ++b) {
        if (resident_[b])
            place(whole, b, partition);
        else
            shapes_[b] = {};
    }
    list_items(whole);
    arrange_worlds(whole);
    plan_ = {};
}

void PartScene::place(const Scene& whole, std::uint32_t b, const Partition& partition) {
    own_[b] = partition.owners()[b] == part_;
    views_[b] = whole.bodies[b];
    views_[b].part = partition.pair_part(b);
    ids_[b] = whole.ids[b];
    if (views_[b].motion != Motion::deforming) return;
    if (own_[b]) {
        shapes_[b] = {};
        blocks_[b] = whole.blocks[b];
        patches_[b] = whole.patches[b];
        box_nodes_[b] = whole.box_nodes[b];
    } else {
        // Its owner measures it, too, maybe at the same time.
        GhostShape& shape = shapes_[b];
        shape.blocks.resize(whole.blocks[b].size);
        shape.patches.resize(whole.patches[b].size);
        shape.box_nodes.resize(whole.box_nodes[b].size);
        blocks_[b] = view_of(shape.blocks);
        patches_[b] = view_of(shape.patches);
        box_nodes_[b] = view_of(shape.box_nodes);
    }
    views_[b].blocks = blocks_[b];
    views_[b].patches = patches_[b];
    views_[b].box_nodes = box_nodes_[b];
}

void PartScene::list_items(const Scene& whole) {
    block_items_.clear();
    ranges_.clear();
    node_items_.clear();
    const auto list_blocks = [&](bool own) {
        for (const BlockRange& range : whole.ranges) {
            if (!resident_[range.body] || (views_[range.body].part == part_) != own) continue;
            const auto first = static_cast<std::uint32_t>(block_items_.size());
            block_items_.insert(block_items_.end(), whole.block_items.begin() + range.first,
                                whole.block_items.begin() + range.last);
            ranges_.push_back({range.body, first, static_cast<std::uint32_t>(block_items_.size())});
        }
    };
    list_blocks(true);
    const std::size_t own = block_items_.size();
    list_blocks(false);
    ghost_blocks_ = static_cast<std::uint32_t>(block_items_.size() - own);
    for (std::uint32_t level = 0; level < BoxLevels::most; ++level) {
        level_begin_[level] = static_cast<std::uint32_t>(node_items_.size());
        for (std::uint32_t i = whole.level_begin[level]; i < whole.level_begin[level + 1]; ++i)
            if (resident_[whole.node_items[i].body]) node_items_.push_back(whole.node_items[i]);
    }
    level_begin_[BoxLevels::most] = static_cast<std::uint32_t>(node_items_.size());
}

void PartScene::arrange_worlds(const Scene& whole) {
    world_begins_.assign(whole.world_begins.size, 0);
    if (world_begins_.empty()) return;
    for (const BodyView& view : views_) ++world_begins_[view.world_place + 1];
    std::partial_sum(world_begins_.begin(), world_begins_.end(), world_begins_.begin());
}

bool PartScene::has(const BodySet& bodies) const {
    return bodies.size() == resident_.size() && !has_others(bodies, resident_);
}

PartScene::Sizes PartScene::sizes() const {
    Sizes sizes;
    for (std::uint32_t b = 0; b < views_.size(); ++b) {
        if (!ids_[b] || !near_[b]) continue;
        ++(own_[b] ? sizes.own : sizes.ghosts);
        sizes.triangles += views_[b].mesh.triangles.size;
    }
    return sizes;
}

void PartScene::update(const Scene& whole, std::span<const std::uint32_t> changed,
                       const BodySet& near) {
    const bool replans = plan_.revision != revision_ ||
                         plan_.settings.temporal != whole.plan->settings.temporal;
    if (replans) {
        plan_ = *whole.plan;
        plan_.revision = revision_;
        for (std::uint32_t b = 0; b < seen_.size(); ++b) {
            seen_[b] = {};
            if (!resident_[b] || whole.seen[b].size == 0) continue;
            shapes_[b].seen.resize(own_[b] ? 0 : whole.seen[b].size);
            seen_[b] = own_[b] ? whole.seen[b] : view_of(shapes_[b].seen);
        }
    }
    changed_.clear();
    arrived_.clear();
    for (const std::uint32_t b : changed) {
        if (!resident_[b]) continue;
        static_cast<BodyInput&>(views_[b]) = whole.bodies[b];
        if (views_[b].motion != Motion::deforming) views_[b].fit = whole.bodies[b].fit;
        views_[b].active = whole.bodies[b].active && near_[b];
        changed_.push_back(b);
    }
    if (has_others(near, near_))
        for (std::uint32_t b = 0; b < near.size(); ++b) {
            if (near[b] <= near_[b]) continue;
            near_[b] = 1;
            views_[b].active = whole.bodies[b].active;
            if (!own_[b]) arrived_.push_back(b);
            changed_.push_back(b);
        }
    std::ranges::sort(changed_);
    changed_.erase(std::ranges::unique(changed_).begin(), changed_.end());
    is_still_ = !replans && changed_.empty();
}

void PartScene::copy_seen(const Scene& whole) {
    for (const std::uint32_t b : arrived_)
        if (seen_[b].size == whole.seen[b].size)
            std::copy(whole.seen[b].begin(), whole.seen[b].end(), seen_[b].begin());
}

Scene PartScene::scene(const Scene& whole) {
    return {.bodies = view_of(views_),
            .ids = view_of(std::as_const(ids_)),
            .changed = view_of(std::as_const(changed_)),
            .excluded = whole.excluded,
            .pair_filter = whole.pair_filter,
            .world_begins = view_of(std::as_const(world_begins_)),
            .block_items = view_of(std::as_const(block_items_)),
            .ghost_blocks = ghost_blocks_,
            .ranges = view_of(std::as_const(ranges_)),
            .blocks = view_of(std::as_const(blocks_)),
            .patches = view_of(std::as_const(patches_)),
            .seen = view_of(std::as_const(seen_)),
            .node_items = view_of(std::as_const(node_items_)),
            .level_begin = level_begin_,
            .box_nodes = view_of(std::as_const(box_nodes_)),
            .plan = &plan_,
            .part = part_,
            .forgets_sides = whole.forgets_sides};
}

}  // namespace pierce
