#include "support/sweep_sah.hpp"

#include <algorithm>
#include <span>
#include <vector>

#include "core/body/body_view.hpp"
#include "core/trace/bvh/forest.hpp"

namespace pierce::test {
namespace {

using bvh::BoxF;

BoxF box_of(std::span<const BoxF> boxes) {
    BoxF all = boxes[0];
    for (const BoxF& box : boxes) all.extend(box);
    return all;
}

void sort_along(int axis, std::span<BoxF> boxes) {
    std::ranges::stable_sort(boxes, {},
                             [=](const BoxF& box) { return box.lower[axis] + box.upper[axis]; });
}

/// Half areas of all boxes in the tree, times what each costs. Reorders `boxes`.
double weighted_area(std::span<BoxF> boxes) {
    const double area = box_of(boxes).half_area();
    if (boxes.size() == 1) return constants::leaf_cost * area;
    double best = std::numeric_limits<double>::infinity();
    int best_axis = 0;
    std::size_t best_split = 1;
    std::vector<double> before(boxes.size() + 1);
    for (int axis = 0; axis < 3; ++axis) {
        sort_along(axis, boxes);
        BoxF left = boxes.front(), right = boxes.back();
        for (std::size_t i = 1; i < boxes.size(); ++i) {
            left.extend(boxes[i - 1]);
            before[i] = left.half_area() * static_cast<double>(i);
        }
        for (std::size_t i = boxes.size() - 1; i > 0; --i) {
            right.extend(boxes[i]);
            const double cost = before[i] +
                                right.half_area() * static_cast<double>(boxes.size() - i);
            if (cost >= best) continue;
            best = cost;
            best_axis = axis;
            best_split = i;
        }
    }
    sort_along(best_axis, boxes);
    return constants::node_cost * area + weighted_area(boxes.first(best_split)) +
           weighted_area(boxes.subspan(best_split));
}

}  // namespace

double sweep_sah_cost(const BodyView& body) {
    std::vector<BoxF> boxes;
    for (std::uint32_t leaf = 0; leaf < body.mesh.leaves.size; ++leaf)
        boxes.push_back(bvh::leaf_box(body, leaf));
    const double area = box_of(boxes).half_area();
    return weighted_area(boxes) / area;
}

}  // namespace pierce::test
