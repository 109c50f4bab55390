#include "core/trace/bvh/forest_plan.hpp"
#include "core/body/body_view.hpp"
#include "core/device/view.hpp"

#include <unordered_map>

namespace pierce::bvh {

bool ForestPlan::arrange(View<const BodyView> bodies) {
    bool changed = seen_.size() != bodies.size;
    seen_.resize(bodies.size);
    for (std::uint32_t b = 0; b < bodies.size; ++b) {
        const Seen now{bodies[b].mesh_key, bodies[b].motion};
        changed |= !(seen_[b] == now);
        seen_[b] = now;
    }
    if (!changed) return false;

    trees_.clear();
    tree_of_leaf_.clear();
    tree_of_body_.assign(bodies.size, no_tree);
    std::unordered_map<std::uint64_t, std::uint32_t> shared;  // by mesh
    for (std::uint32_t b = 0; b < bodies.size; ++b) {
        if (seen_[b].mesh_key == 0) continue;
        const auto next = static_cast<std::uint32_t>(trees_.size());
        const bool moves = seen_[b].motion == Motion::deforming;
        tree_of_body_[b] = moves ? next : shared.try_emplace(seen_[b].mesh_key, next).first->second;
        if (tree_of_body_[b] != next) continue;
        const auto first = static_cast<std::uint32_t>(tree_of_leaf_.size());
        trees_.push_back({.first = first,
                          .count = bodies[b].mesh.leaves.size,
                          .body = b,
                          .moves = moves,
                          .root = {},
                          .fitted = 0});
        tree_of_leaf_.insert(tree_of_leaf_.end(), bodies[b].mesh.leaves.size, next);
    }
    return true;
}

}  // namespace pierce::bvh
