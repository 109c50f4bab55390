#include "core/mesh_build/winding_tree.hpp"

#include <algorithm>
#include <bit>
#include <numbers>

#include "core/mesh_build/spatial_order.hpp"
#include "pierce/constants.hpp"

namespace pierce {

WindingTree::WindingTree(std::span<const Vec3f> positions, std::span<const Triangle> triangles)
    : positions_(positions), triangles_(triangles) {
    std::vector<Vec3f> middles;
    middles.reserve(triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        middles.push_back(to_float((1.0 / 3) * (corner(t, 0) + corner(t, 1) + corner(t, 2))));
    order_ = spatial_order(middles);
    build(0, static_cast<std::uint32_t>(order_.size()));
}

void WindingTree::build(std::uint32_t begin, std::uint32_t end) {
    if (begin == end) return;
    const std::size_t place = nodes_.size();
    Node node{.begin = begin, .end = end, .skip = 0, .center = {}, .area = {}};
    double weights = 0;
    for (std::uint32_t i = begin; i < end; ++i) {
        const Vec3d a = corner(order_[i], 0), b = corner(order_[i], 1), c = corner(order_[i], 2);
        const Vec3d area = 0.5 * cross(b - a, c - a);
        node.area += area;
        node.center += length(area) * (1.0 / 3) * (a + b + c);
        weights += length(area);
    }
    node.center = weights > 0 ? node.center * (1 / weights) : corner(order_[begin], 0);
    for (std::uint32_t i = begin; i < end; ++i)
        for (int k = 0; k < 3; ++k)
            node.radius = std::max(node.radius, length(corner(order_[i], k) - node.center));
    nodes_.push_back(node);
    if (end - begin > constants::winding_leaf) {
        // spatial_order() lays full halves first.
        const std::uint32_t half = std::bit_ceil(end - begin) / 2;
        build(begin, begin + half);
        build(begin + half, end);
    }
    nodes_[place].skip = static_cast<std::uint32_t>(nodes_.size());
}

double WindingTree::at(Vec3d p, std::uint32_t left_out) const {
    double sum = 0;
    for (std::size_t n = 0; n < nodes_.size();) {
        const Node& node = nodes_[n];
        const Vec3d way = node.center - p;
        const double distance = length(way);
        if (distance > constants::winding_reach * node.radius) {
            sum += dot(node.area, way) / (distance * distance * distance);
            n = node.skip;
            continue;
        }
        if (node.skip == n + 1)
            for (std::uint32_t i = node.begin; i < node.end; ++i)
                if (order_[i] != left_out) sum += angle_of(order_[i], p);
        ++n;
    }
    return sum / (4 * std::numbers::pi);
}

double WindingTree::exactly_at(Vec3d p, std::uint32_t left_out) const {
    double sum = 0;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
        if (t != left_out) sum += angle_of(t, p);
    return sum / (4 * std::numbers::pi);
}

}  // namespace pierce
