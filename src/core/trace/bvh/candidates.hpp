#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/bvh/traversal.hpp"
#include "core/trace/bvh/tree_work.hpp"
#include "core/trace/triangle_sieve.hpp"

namespace pierce::bvh {

/// The triangles that a ray may cross, in any order: as many as fit in 128 bytes with their number.
struct alignas(16) Candidates {
    static constexpr std::uint32_t capacity = 31;
    static constexpr std::uint32_t too_many = capacity + 1;  ///< there may be more than the list
                                                             ///< holds

    std::uint32_t count = 0;
    std::uint32_t triangle[capacity];
};

/// Per ray: the triangles that it may cross; and the work this took, if the tree's body deforms.
/// The search uses float32 only: the exact test keeps so much about a ray that a GPU would have too
/// few threads to hide the wait for memory.
struct FindCandidates {
    View<const BodyView> bodies;
    Forest forest;
    View<const Ray> rays;
    View<Candidates> candidates;
    View<TreeWork> work;  ///< per tree

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Ray ray = rays[i];
        candidates[i].count = 0;
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
    // How many leaves are gathered before they are tested. A vertex on its own surface meets the
    // boxes of half a dozen leaves.
    static constexpr std::uint32_t leaf_room = 16;

    PIERCE_HD std::uint32_t find(const BodyView& body, const Tree& tree, const Ray& ray,
                                 std::uint32_t* triangles, RayWork& done) const {
        const Surface surface = body.surface();
        const BoxRay box_ray(ray, positions_box(body), body.touch);
        const CrossingSearch search(ray, surface);
        const float begin = round_down(search.begin() - box_ray.margin());
        const float end = round_up(search.limit() + box_ray.margin());
        const TriangleSieve sieve(ray);
        std::uint32_t leaves[leaf_room], open[constants::traversal_stack];
        std::uint32_t found = 0, opened = 1, count = 0;
        open[0] = no_node;  // popped when nothing is left
        Item item = tree.root;
        bool more = !item.is_leaf();
        if (!more) leaves[found++] = item.code;
        while (true) {
            // All threads of a warp gather leaves, then all test theirs. While they gather, all
            // threads do the same, whatever they meet: at every branch some threads would wait for
            // the others.
            while (more && found + 2 <= leaf_room) {
                const Node node = read_whole(forest.nodes[item.index()]);
                ++done.nodes;
                const Item first = node.child[0], second = node.child[1];
                const bool meets_first = box_ray.meets(node.box[0], begin, end);
                const bool meets_second = box_ray.meets(node.box[1], begin, end);
                leaves[found] = first.code;
                found += meets_first && first.is_leaf();
                leaves[found] = second.code;
                found += meets_second && second.is_leaf();
                const bool opens_first = meets_first && !first.is_leaf(),
                           opens_second = meets_second && !second.is_leaf();
                if (opened == constants::traversal_stack) return Candidates::too_many;
                open[opened] = second.code;
                opened += opens_first && opens_second;
                item = opens_first ? first : second;
                if (!opens_first && !opens_second) item.code = open[--opened];
                more = item.code != no_node;
            }
            for (std::uint32_t k = 0; k < found; ++k) {
                const Leaf leaf = read_whole(body.mesh.leaves[Item{leaves[k]}.index()]);
                done.tests += leaf.size();
                const std::uint32_t crossed = sieve.may_cross(surface.positions[leaf.corner[0]],
                                                              surface.positions[leaf.corner[1]],
                                                              surface.positions[leaf.corner[2]],
                                                              surface.positions[leaf.corner[3]]) &
                                              ~excluded_of(leaf, ray.excluded);
                if (crossed == 0) continue;
                if (count + 2 > Candidates::capacity) return Candidates::too_many;
                triangles[count] = leaf.triangle[0];
                count += crossed & 1;
                triangles[count] = leaf.triangle[1];
                count += crossed >> 1;
            }
            if (!more) return count;
            found = 0;
        }
    }
};

}  // namespace pierce::bvh
