#include "core/mesh_build/box_tree.hpp"

#include <algorithm>
#include <numeric>

namespace pierce {
namespace {

constexpr std::uint32_t leaf_size = 4;

int longest_axis(Vec3d size) {
    if (size.x >= size.y && size.x >= size.z) return 0;
    return size.y >= size.z ? 1 : 2;
}

}  // namespace

BoxTree::BoxTree(std::vector<Box> boxes)
    : boxes_(std::move(boxes)), order_(boxes_.size()), nodes_(1) {
    std::iota(order_.begin(), order_.end(), 0u);
    split(0, 0, static_cast<std::uint32_t>(order_.size()));
}

void BoxTree::split(std::uint32_t node, std::uint32_t first, std::uint32_t last) {
    Box box;
    for (std::uint32_t i = first; i < last; ++i) box.extend(boxes_[order_[i]]);
    if (last - first <= leaf_size) {
        nodes_[node] = {box, first, last - first};
        return;
    }
    const int axis = longest_axis(box.upper - box.lower);
    const std::uint32_t middle = first + (last - first) / 2;
    std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                     [&](std::uint32_t a, std::uint32_t b) {
                         const double ca = boxes_[a].center()[axis], cb = boxes_[b].center()[axis];
                         return ca != cb ? ca < cb : a < b;
                     });
    const auto children = static_cast<std::uint32_t>(nodes_.size());
    nodes_[node] = {box, children, 0};
    nodes_.resize(nodes_.size() + 2);
    split(children, first, middle);
    split(children + 1, middle, last);
}

}  // namespace pierce
