#include "core/mesh_build/spatial_order.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

#include "pierce/box.hpp"

namespace pierce {
namespace {

int longest_axis(const Box& box) {
    const Vec3d size = box.half_size();
    return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

void put_in_order(std::span<const Vec3d> points, std::span<std::uint32_t> order) {
    if (order.size() < 2) return;
    Box box;
    for (std::uint32_t i : order) box.extend(points[i]);
    const int axis = longest_axis(box);
    const std::size_t half = std::bit_ceil(order.size()) / 2;
    std::ranges::nth_element(order, order.begin() + static_cast<std::ptrdiff_t>(half), {},
                             [&](std::uint32_t i) { return std::pair(points[i][axis], i); });
    put_in_order(points, order.first(half));
    put_in_order(points, order.subspan(half));
}

}  // namespace

std::vector<std::uint32_t> spatial_order(std::span<const Vec3d> points) {
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    put_in_order(points, order);
    return order;
}

}  // namespace pierce
