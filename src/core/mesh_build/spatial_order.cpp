#include "core/mesh_build/spatial_order.hpp"

#include <algorithm>
#include <bit>

#include "core/base/workers.hpp"
#include "pierce/box.hpp"

namespace pierce {
namespace {

/// A point and its number side by side: sorting then reads memory in order.
struct Numbered {
    Vec3d point;
    std::uint32_t number = 0;
};

int longest_axis(const Box& box) {
    const Vec3d size = box.half_size();
    return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

/// Halves that are smaller are not worth a thread.
constexpr std::size_t least_shared = 4096;

void put_in_order(std::span<Numbered> points, std::uint32_t threads) {
    if (points.size() < 2) return;
    Box box;
    for (const Numbered& p : points) box.extend(p.point);
    const int axis = longest_axis(box);
    const std::size_t half = std::bit_ceil(points.size()) / 2;
    const auto along = [&](auto member) {
        std::ranges::nth_element(points, points.begin() + static_cast<std::ptrdiff_t>(half),
                                 [member](const Numbered& p, const Numbered& q) {
                                     const double at_p = p.point.*member, at_q = q.point.*member;
                                     return at_p != at_q ? at_p < at_q : p.number < q.number;
                                 });
    };
    if (axis == 0) along(&Vec3d::x);
    if (axis == 1) along(&Vec3d::y);
    if (axis == 2) along(&Vec3d::z);
    const auto first = [&] { put_in_order(points.first(half), (threads + 1) / 2); };
    const auto second = [&] { put_in_order(points.subspan(half), std::max(threads / 2, 1u)); };
    if (threads > 1 && points.size() >= least_shared) {
        Workers(threads).side_by_side("order", first, second);
    } else {
        first();
        second();
    }
}

}  // namespace

std::vector<std::uint32_t> spatial_order(std::span<const Vec3d> points, std::uint32_t threads) {
    std::vector<Numbered> numbered(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i) numbered[i] = {points[i], i};
    put_in_order(numbered, threads);
    std::vector<std::uint32_t> order(points.size());
    std::ranges::transform(numbered, order.begin(), &Numbered::number);
    return order;
}

}  // namespace pierce
