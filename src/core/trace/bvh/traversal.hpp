#pragma once

#include "core/body/body_view.hpp"
#include "core/device/quick_math.hpp"
#include "core/device/whole.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/geometry/quick_vec3.hpp"
#include "core/trace/bvh/forest.hpp"
#include "core/trace/closest_search.hpp"
#include "core/trace/first_crossing.hpp"
#include "pierce/min_max.hpp"

namespace pierce::bvh {

/// A ray in float32, for boxes. Boxes are grown by two margins, so that no box is missed that the
/// exact ray meets. One is constants::slab_margin of the largest coordinate, which covers all
/// rounding of the slab test. The other is `touch`, the distance within which a ray in a triangle's
/// plane touches the triangle.
class BoxRay {
public:
    PIERCE_HD BoxRay(const Ray& ray, const Box& around, double touch) {
        double largest = around.max_coordinate();
        for (int k = 0; k < 3; ++k) largest = max_of(std::fabs(ray.origin[k]), largest);
        margin_ = constants::slab_margin * largest + touch;
        const float smallest = max_of(constants::smallest_slope, constants::slope_per_coordinate *
                                                                     static_cast<float>(largest));
        for (int k = 0; k < 3; ++k) {
            const float d = static_cast<float>(ray.direction[k]);
            inverse_[k] = 1.0f / (std::fabs(d) > smallest ? d : d < 0 ? -smallest : smallest);
            low_[k] = -(round_up(ray.origin[k] + margin_) * inverse_[k]);
            high_[k] = -(round_down(ray.origin[k] - margin_) * inverse_[k]);
        }
    }

    PIERCE_HD double margin() const { return margin_; }

    /// True if the ray is inside the box somewhere between `begin` and `end`.
    PIERCE_HD bool meets(const BoxF& box, float begin, float end) const {
        clip(box, begin, end);
        return begin <= end;
    }

    /// Where the ray enters the box, if it is inside somewhere between `begin` and `end`; else
    /// infinity.
    PIERCE_HD float enter(const BoxF& box, float begin, float end) const {
        clip(box, begin, end);
        return begin <= end ? begin : INFINITY;
    }

private:
    PIERCE_HD void clip(const BoxF& box, float& near, float& far) const {
        clip(0, box.lower.x, box.upper.x, near, far);
        clip(1, box.lower.y, box.upper.y, near, far);
        clip(2, box.lower.z, box.upper.z, near, far);
    }

    PIERCE_HD void clip(int k, float lower, float upper, float& near, float& far) const {
        const float a = quick_fma(lower, inverse_[k], low_[k]),
                    b = quick_fma(upper, inverse_[k], high_[k]);
        near = quick_max(quick_min(a, b), near);
        far = quick_min(quick_max(a, b), far);
    }

    double margin_ = 0;
    float inverse_[3], low_[3], high_[3];  ///< a coordinate x is at x * inverse + low, or x *
                                           ///< inverse + high, along the ray
};

/// A stack of tree items. A binary tree over Morton codes is no deeper than the 64 bits of a code
/// plus the 32 bits of a tie; but a restructured tree may be deeper. The caller owns the stack's
/// memory: if it were in the same object, a GPU would keep the stack's size in memory, too.
class ItemStack {
public:
    using Memory = std::uint32_t[constants::traversal_stack];  // not Items: each would be
                                                               // initialized first

    PIERCE_HD explicit ItemStack(Memory& memory) : codes_(memory) {}

    PIERCE_HD bool empty() const { return size_ == 0; }
    PIERCE_HD bool full() const { return size_ == constants::traversal_stack; }
    PIERCE_HD void push(Item item) { codes_[size_++] = item.code; }
    PIERCE_HD Item pop() { return {codes_[--size_]}; }

private:
    std::uint32_t* codes_;
    std::uint32_t size_ = 0;
};

/// What a ray has cost.
struct RayWork {
    std::uint32_t nodes = 0;  ///< looked at
    std::uint32_t tests = 0;  ///< of triangles
};

/// A bit for each of a leaf's triangles that a ray with these `excluded` vertices does not hit; in
/// a leaf with one triangle, also for the missing second one.
PIERCE_HD inline std::uint32_t excluded_of(const Leaf& leaf, const std::uint32_t (&excluded)[2]) {
    const auto has = [&](std::uint32_t k, std::uint32_t v) { return leaf.corner[k] == v; };
    std::uint32_t both = 3;
    for (std::uint32_t v : excluded) {
        const bool at_edge = has(1, v) || has(2, v);
        both &= std::uint32_t{at_edge || has(0, v)} | std::uint32_t{at_edge || has(3, v)} << 1;
    }
    return both | std::uint32_t{leaf.triangle[1] == no_triangle} << 1;
}

/// Shows a search a leaf's triangles.
template <class Search>
PIERCE_HD void show_leaf(const BodyView& body, std::uint32_t leaf, Search& search) {
    const Leaf at = read_whole(body.mesh.leaves[leaf]);
    search.test(at.triangle[0]);
    if (at.triangle[1] != no_triangle) search.test(at.triangle[1]);
}

/// Shows a search all triangles there are.
template <class Search>
PIERCE_HD void show_all(const BodyView& body, Search& search) {
    for (std::uint32_t t = 0; t < body.mesh.triangles.size; ++t) search.test(t);
}

/// Shows a search all triangles its ray may meet, near ones first. If the tree is deeper than the
/// stack, it shows all triangles of the body.
PIERCE_HD inline void show_near(const Forest& forest, const Tree& tree, const BodyView& body,
                                const BoxRay& ray, CrossingSearch& search) {
    const float begin = round_down(search.begin() - ray.margin());
    float end = round_up(search.limit() + ray.margin());
    ItemStack::Memory memory;
    ItemStack stack(memory);
    Item item = tree.root;
    while (true) {
        // All threads of a warp look for a leaf, then all test theirs.
        while (!item.is_leaf()) {
            const Node node = read_whole(forest.nodes[item.index()]);
            const float t0 = ray.enter(node.box[0], begin, end),
                        t1 = ray.enter(node.box[1], begin, end);
            const std::uint32_t first = t1 < t0 ? 1 : 0;
            const float nearer = first ? t1 : t0, other = first ? t0 : t1;
            if (!(nearer < INFINITY)) {
                if (stack.empty()) return;
                item = stack.pop();
                continue;
            }
            item = node.side(first);
            if (!(other < INFINITY)) continue;
            if (stack.full()) return show_all(body, search);
            stack.push(node.side(1 - first));
        }
        show_leaf(body, item.index(), search);
        end = round_up(search.limit() + ray.margin());
        if (stack.empty()) return;
        item = stack.pop();
    }
}

/// Shows a search all triangles that may be closest to its point, near ones first. If the tree is
/// deeper than the stack, it shows all triangles of the body.
PIERCE_HD inline void show_near(const Forest& forest, const Tree& tree, const BodyView& body,
                                ClosestSearch& search) {
    ItemStack::Memory memory;
    ItemStack stack(memory);
    Item item = tree.root;
    while (true) {
        if (item.is_leaf()) {
            show_leaf(body, item.index(), search);
        } else {
            const Node& node = forest.nodes[item.index()];
            double gap[2];
            for (int side = 0; side < 2; ++side)
                gap[side] = Box{to_double(node.box[side].lower), to_double(node.box[side].upper)}
                                .distance(search.point());
            const int first = gap[1] < gap[0] ? 1 : 0;
            for (int k = 0; k < 2; ++k) {
                const int side = k == 0 ? 1 - first : first;
                if ((side == 0 ? gap[0] : gap[1]) > search.limit()) continue;
                if (stack.full()) return show_all(body, search);
                stack.push(node.child[side]);
            }
        }
        if (stack.empty()) return;
        item = stack.pop();
    }
}

}  // namespace pierce::bvh
