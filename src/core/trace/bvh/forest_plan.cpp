#include "core/trace/bvh/forest_plan.hpp"

#include <algorithm>

namespace pierce::bvh {
namespace {

// Where meshes change, a share of all leaves is kept free for trees that grow.
constexpr std::uint32_t spare_share = 4, spare_leaves = 1024;
// Trees that change one by one become LBVHs. If they are more than a share of all, better trees are
// built for all bodies.
constexpr std::uint32_t rebuilt_share = 4;

}  // namespace

ForestPlan::Change ForestPlan::arrange(View<const BodyView> bodies) {
    bool are_others = seen_.size() != bodies.size;
    std::vector<std::uint32_t> changed;
    for (std::uint32_t b = 0; b < bodies.size && !are_others; ++b) {
        const Seen now{bodies[b].mesh_key, bodies[b].motion};
        if (seen_[b] == now) continue;
        changed.push_back(b);
        are_others = seen_[b].motion != now.motion || seen_[b].mesh_key == 0 || now.mesh_key == 0;
    }
    if (!are_others && changed.empty()) return Change::none;

    seen_.clear();
    for (const BodyView& body : bodies) seen_.push_back({body.mesh_key, body.motion});
    const bool had_room = meshes_change_;
    meshes_change_ = meshes_change_ || !are_others;
    if (!are_others && had_room && change(bodies, changed)) return Change::some;
    lay_out(bodies);
    return Change::all;
}

void ForestPlan::lay_out(View<const BodyView> bodies) {
    trees_.clear();
    users_.clear();
    tree_of_leaf_.clear();
    tree_of_mesh_.clear();
    tree_of_body_.assign(bodies.size, no_tree);
    std::vector<std::uint32_t> counts;
    for (std::uint32_t b = 0; b < bodies.size; ++b) {
        if (bodies[b].mesh_key == 0) continue;
        const auto next = static_cast<std::uint32_t>(trees_.size());
        const bool moves = bodies[b].motion == Motion::deforming;
        const std::uint32_t t = tree_of_body_[b] = moves
                                                       ? next
                                                       : tree_of_mesh_
                                                             .try_emplace(bodies[b].mesh_key, next)
                                                             .first->second;
        if (t != next) {
            ++users_[t];
            continue;
        }
        const auto first = static_cast<std::uint32_t>(tree_of_leaf_.size());
        counts.push_back(bodies[b].mesh.leaves.size);
        users_.push_back(1);
        trees_.push_back({.first = first,
                          .count = counts.back(),
                          .body = b,
                          .moves = moves,
                          .root = {},
                          .fitted = Tree::fits_nothing});
        tree_of_leaf_.insert(tree_of_leaf_.end(), counts.back(), next);
    }
    tree_count_ = static_cast<std::uint32_t>(trees_.size());
    leaf_count_ = static_cast<std::uint32_t>(tree_of_leaf_.size());
    is_dense_ = bodies_change_trees_ = true;
    const std::uint32_t spare = meshes_change_ ? leaf_count_ / spare_share + spare_leaves : 0;
    if (meshes_change_) {
        // Bodies that share a mesh may get one each.
        trees_.resize(std::max(bodies.size, tree_count_), Tree{});
        users_.resize(trees_.size(), 0);
        counts.resize(trees_.size(), 0);
    }
    places_.lay_out(counts, spare);
    tree_of_leaf_.resize(places_.room(), no_tree);
}

/// The tree that a body that keeps its shape has for its new mesh; `before`: its tree so far.
std::uint32_t ForestPlan::shared_tree(const BodyView& body, std::uint32_t before) {
    const auto known = tree_of_mesh_.find(body.mesh_key);
    if (known != tree_of_mesh_.end()) return known->second;
    std::uint32_t tree = before;
    if (users_[before] > 0)
        tree = static_cast<std::uint32_t>(std::ranges::find(users_, 0u) - users_.begin());
    std::erase_if(tree_of_mesh_, [&](const auto& entry) { return entry.second == tree; });
    tree_of_mesh_.emplace(body.mesh_key, tree);
    return tree;
}

bool ForestPlan::change(View<const BodyView> bodies, std::span<const std::uint32_t> of_bodies) {
    changed_.clear();
    bodies_change_trees_ = false;
    std::uint64_t leaves = 0;
    for (std::uint32_t b : of_bodies) leaves += bodies[b].mesh.leaves.size;
    if (leaves * rebuilt_share > leaf_count_) return false;
    // First the shared trees that bodies leave become free.
    for (std::uint32_t b : of_bodies)
        if (bodies[b].motion != Motion::deforming) --users_[tree_of_body_[b]];
    for (std::uint32_t b : of_bodies) {
        const BodyView& body = bodies[b];
        const bool moves = body.motion == Motion::deforming;
        const std::uint32_t before = tree_of_body_[b],
                            t = moves ? before : shared_tree(body, before);
        bodies_change_trees_ = bodies_change_trees_ || t != before;
        tree_of_body_[b] = t;
        if (!moves && users_[t]++ > 0) continue;
        const std::uint32_t first = places_.first(t), count = places_.size(t);
        if (!places_.resize(t, body.mesh.leaves.size)) return false;
        trees_[t] = {.first = places_.first(t),
                     .count = places_.size(t),
                     .body = b,
                     .moves = moves,
                     .root = {},
                     .fitted = Tree::fits_nothing};
        changed_.push_back(
            {.tree = trees_[t], .place = t, .first_before = first, .count_before = count});
    }
    is_dense_ = false;
    return true;
}

}  // namespace pierce::bvh
