#pragma once

#include "pierce/core/bvh/traversal.hpp"
#include "pierce/core/bvh/tree_work.hpp"
#include "pierce/core/bvh/triangle_sieve.hpp"

namespace pierce::bvh {

/// The triangles that a ray may cross, in any order: as many as fit in 128 bytes with their number.
struct alignas(16) Candidates {
    static constexpr std::uint32_t capacity = 31;
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

    static constexpr bool is_uneven = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Ray ray = rays[i];
        if (!(ray.t_max >= 0)) return;
        const BodyView& body = bodies[ray.target];
        const std::uint32_t t = forest.tree_of_body[ray.target];
        const Tree& tree = forest.trees[t];
        RayWork done;
        candidates[i].count = find(body, tree, ray, candidates[i].triangle, done);
        if (!tree.moves) return;
        atomic_count(work[t].rays, 1);
        atomic_count(work[t].nodes, done.nodes);
        atomic_count(work[t].tests, done.tests);
    }

private:
    // Leaves gathered before they are tested. A vertex on its own surface meets the boxes of a dozen.
    static constexpr std::uint32_t leaf_room = 16;

    PIERCE_HD std::uint32_t find(const BodyView& body, const Tree& tree, const Ray& ray, std::uint32_t* triangles,
                                 RayWork& done) const {
        const Surface surface = body.surface();
        const BoxRay box_ray(ray, positions_box(body));
        const CrossingSearch search(ray, surface);
        const float begin = round_down(search.begin() - box_ray.margin());
        const float end = round_up(search.limit() + box_ray.margin());
        const TriangleSieve sieve(ray);
        std::uint32_t leaves[leaf_room];
        std::uint32_t found = 0, count = 0;
        ItemStack::Memory memory;
        ItemStack stack(memory);
        Item item = tree.root;
        bool more = !item.is_leaf();
        if (!more) leaves[found++] = item.index();
        while (true) {
            // All threads of a warp gather leaves, then all test theirs.
            while (more && found + 2 <= leaf_room) {
                const Node node = read_whole(forest.nodes[item.index()]);
                ++done.nodes;
                Item next;
                bool has_next = false;
                for (std::uint32_t side = 0; side < 2; ++side) {
                    if (!(box_ray.enter(side == 0 ? node.box[0] : node.box[1], begin, end) < INFINITY)) continue;
                    const Item child = node.side(side);
                    if (child.is_leaf()) {
                        leaves[found++] = child.index();
                    } else if (!has_next) {
                        next = child;
                        has_next = true;
                    } else {
                        if (stack.full()) return Candidates::too_many;
                        stack.push(child);
                    }
                }
                more = has_next || !stack.empty();
                if (more) item = has_next ? next : stack.pop();
            }
            done.tests += found;
            for (std::uint32_t k = 0; k < found; ++k) {
                const Triangle t = surface.triangles[leaves[k]];
                if (is_excluded(t, ray.excluded)) continue;
                if (!sieve.may_cross(surface.positions[t.vertex[0]], surface.positions[t.vertex[1]],
                                     surface.positions[t.vertex[2]]))
                    continue;
                if (count == Candidates::capacity) return Candidates::too_many;
                triangles[count++] = leaves[k];
            }
            if (!more) return count;
            found = 0;
        }
    }
};

}  // namespace pierce::bvh
