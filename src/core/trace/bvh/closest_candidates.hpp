#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/bvh/candidates.hpp"
#include "core/trace/bvh/traversal.hpp"
#include "core/trace/closest_search.hpp"
#include "core/trace/point_sieve.hpp"

/// The triangle closest to a point, in three parts, as for rays: candidates in float32, the exact
/// search among them, and the exact search through the tree for the few points with too many.
namespace pierce::bvh {

/// Per ray: the triangles that may be closest to its origin.
struct FindClosestCandidates {
    View<const BodyView> bodies;
    Forest forest;
    View<const Ray> rays;
    View<Candidates> candidates;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Ray ray = rays[i];
        if (!(ray.t_max >= 0)) return;
        const BodyView& body = bodies[ray.target];
        const Tree& tree = forest.trees[forest.tree_of_body[ray.target]];
        candidates[i].count = find(body, tree, ray, candidates[i].triangle);
    }

private:
    static constexpr std::uint32_t leaf_room = 8;

    PIERCE_HD std::uint32_t find(const BodyView& body, const Tree& tree, const Ray& ray,
                                 std::uint32_t* triangles) const {
        const View<const Vec3f> positions = body.positions;
        PointSieve sieve(ray.origin, ray.t_max, positions_box(body));
        // As ClosestSearch::may_leave_out().
        if (body.mesh.covered.size > 0 || ray.excluded[0] != no_triangle) sieve.keep_limit();
        std::uint32_t leaves[leaf_room], open[constants::traversal_stack];
        std::uint32_t found = 0, opened = 1, count = 0;
        open[0] = no_node;  // popped when nothing is left
        Item item = tree.root;
        bool more = !item.is_leaf();
        if (!more) leaves[found++] = item.code;
        while (true) {
            // All threads of a warp gather leaves, then all test theirs.
            while (more && found + 2 <= leaf_room) {
                const Node node = read_whole(forest.nodes[item.index()]);
                const float gap[2] = {sieve.squared_to(node.box[0].lower, node.box[0].upper),
                                      sieve.squared_to(node.box[1].lower, node.box[1].upper)};
                const bool swap = gap[1] < gap[0];
                const Item near = swap ? node.child[1] : node.child[0],
                           far = swap ? node.child[0] : node.child[1];
                const bool holds_near = sieve.may_hold(swap ? gap[1] : gap[0]),
                           holds_far = sieve.may_hold(swap ? gap[0] : gap[1]);
                leaves[found] = near.code;
                found += holds_near && near.is_leaf();
                leaves[found] = far.code;
                found += holds_far && far.is_leaf();
                const bool opens_near = holds_near && !near.is_leaf(),
                           opens_far = holds_far && !far.is_leaf();
                if (opened == constants::traversal_stack) return Candidates::too_many;
                open[opened] = far.code;
                opened += opens_near && opens_far;
                item = opens_near ? near : far;
                if (!opens_near && !opens_far) item.code = open[--opened];
                more = item.code != no_node;
            }
            for (std::uint32_t k = 0; k < found; ++k) {
                const Leaf leaf = read_whole(body.mesh.leaves[Item{leaves[k]}.index()]);
                const Vec3f b = positions[leaf.corner[1]], c = positions[leaf.corner[2]];
                if (count + 2 > Candidates::capacity) return Candidates::too_many;
                triangles[count] = leaf.triangle[0];
                count += sieve.may_be_closest(positions[leaf.corner[0]], b, c);
                triangles[count] = leaf.triangle[1];
                count += leaf.triangle[1] != no_triangle &&
                         sieve.may_be_closest(positions[leaf.corner[3]], b, c);
            }
            if (!more) return count;
            found = 0;
        }
    }
};

/// Per ray: the closest one of its candidates, or none.
struct ClosestOfCandidates {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const Candidates> candidates;
    View<std::uint32_t> triangles;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const Ray ray = rays[i];
        triangles[i] = no_triangle;
        if (!(ray.t_max >= 0)) return;
        const Candidates& known = candidates[i];
        const std::uint32_t count = known.count;
        if (count == Candidates::too_many) return;
        triangles[i] = closest_triangle(ray, bodies[ray.target].surface(),
                                        [&](ClosestSearch& search) {
                                            for (std::uint32_t k = 0; k < count; ++k)
                                                search.test(known.triangle[k]);
                                        });
    }
};

/// Per ray with too many candidates: the triangle closest to its origin, through the tree.
struct ClosestInTree {
    View<const BodyView> bodies;
    Forest forest;
    View<const Ray> rays;
    View<const Candidates> candidates;
    View<std::uint32_t> triangles;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (!(rays[i].t_max >= 0) || candidates[i].count != Candidates::too_many) return;
        const std::uint32_t target = rays[i].target;
        const BodyView& body = bodies[target];
        triangles[i] = closest_triangle(rays[i], body.surface(), [&](ClosestSearch& search) {
            show_near(forest, forest.trees[forest.tree_of_body[target]], body, search);
        });
    }
};

}  // namespace pierce::bvh
