#pragma once

#include "pierce/core/bvh/traversal.hpp"
#include "pierce/core/bvh/tree_work.hpp"
#include "pierce/core/bvh/triangle_sieve.hpp"

namespace pierce::bvh {

/// The triangles that a ray may cross, in any order.
struct alignas(16) Candidates {
    static constexpr std::uint32_t capacity = 15;
    static constexpr std::uint32_t too_many = capacity + 1;  ///< there may be others

    std::uint32_t count = 0;
    std::uint32_t triangle[capacity];
};

/// Per ray: the triangles that it may cross; and what that cost its tree, if it moves. In float32 alone: what the exact
/// test remembers of a ray would leave a GPU few threads to wait for memory with.
struct FindCandidates {
    View<const BodyView> bodies;
    Forest forest;
    View<const Ray> rays;
    View<Candidates> candidates;
    View<TreeWork> work;  ///< per tree

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Ray ray = rays[i];
        if (!(ray.t_max >= 0)) return;
        const BodyView& body = bodies[ray.target];
        const std::uint32_t t = forest.tree_of_body[ray.target];
        const Tree& tree = forest.trees[t];
        RayWork done;
        candidates[i].count = find(body, tree, ray, candidates[i].triangle, done);
        if (!tree.moves) return;
        atomic_add(work[t].rays, 1);
        atomic_add(work[t].nodes, done.nodes);
        atomic_add(work[t].tests, done.tests);
    }

private:
    PIERCE_HD std::uint32_t find(const BodyView& body, const Tree& tree, const Ray& ray, std::uint32_t* triangles,
                                 RayWork& done) const {
        const Surface surface = body.surface();
        const BoxRay box_ray(ray, positions_box(body));
        const CrossingSearch search(ray, surface);
        const float begin = round_down(search.begin() - box_ray.margin());
        const float end = round_up(search.limit() + box_ray.margin());
        const TriangleSieve sieve(ray);
        std::uint32_t count = 0;
        ItemStack stack;
        Item item = tree.root;
        while (true) {
            // All threads of a warp look for a leaf, then all test theirs.
            while (!item.is_leaf()) {
                const Node node = read_whole(forest.nodes[item.index()]);
                ++done.nodes;
                const bool first = box_ray.enter(node.box[0], begin, end) < INFINITY;
                const bool second = box_ray.enter(node.box[1], begin, end) < INFINITY;
                if (first && second) {
                    if (stack.full()) return Candidates::too_many;
                    stack.push(node.child[1]);
                }
                if (first || second)
                    item = node.side(first ? 0 : 1);
                else if (stack.empty())
                    return count;
                else
                    item = stack.pop();
            }
            ++done.tests;
            const Triangle corners = surface.triangles[item.index()];
            if (sieve.may_cross(surface.positions[corners.vertex[0]], surface.positions[corners.vertex[1]],
                                surface.positions[corners.vertex[2]])) {
                if (count == Candidates::capacity) return Candidates::too_many;
                triangles[count++] = item.index();
            }
            if (stack.empty()) return count;
            item = stack.pop();
        }
    }
};

}  // namespace pierce::bvh
