#include "core/mesh_build/spatial_order.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "core/base/workers.hpp"
#include "core/device/four.hpp"

namespace pierce {
namespace {

/// A point and its number side by side: sorting then reads memory in order.
struct Numbered {
    float at[3];
    std::uint32_t number = 0;
};

/// The box around points; the fourth lane means nothing.
struct Range {
    Four lower = std::numeric_limits<float>::infinity(),
         upper = -std::numeric_limits<float>::infinity();

    explicit Range(std::span<const Numbered> points) {
        for (const Numbered& p : points) {
            const Four at = Four::at(&p);
            lower = min_of(at, lower);
            upper = max_of(at, upper);
        }
    }
};

std::uint32_t longest_axis(const Range& a, const Range& b) {
    const Four size = max_of(a.upper, b.upper) - min_of(a.lower, b.lower);
    if (size[0] >= size[1] && size[0] >= size[2]) return 0;
    return size[1] >= size[2] ? 1 : 2;
}

/// Halves that are smaller are not worth a thread.
constexpr std::size_t least_shared = 4096;

class SpatialSort {
public:
    explicit SpatialSort(std::size_t leaf) : leaf_(leaf) {}

    void operator()(std::span<Numbered> points, std::uint32_t threads) const {
        if (points.size() <= leaf_) {
            std::ranges::sort(points, {}, &Numbered::number);
            return;
        }
        const std::size_t half = std::bit_ceil(points.size()) / 2;
        const std::span<Numbered> left = points.first(half), right = points.subspan(half);
        const Range lower(left), upper(right);
        const std::uint32_t axis = longest_axis(lower, upper);
        const auto is_before = [axis](const Numbered& p, const Numbered& q) {
            return p.at[axis] != q.at[axis] ? p.at[axis] < q.at[axis] : p.number < q.number;
        };
        const bool is_parted = lower.upper[axis] < upper.lower[axis] ||
                               (lower.upper[axis] == upper.lower[axis] &&
                                is_before(*std::ranges::max_element(left, is_before),
                                          *std::ranges::min_element(right, is_before)));
        if (!is_parted)
            std::ranges::nth_element(points, points.begin() + static_cast<std::ptrdiff_t>(half),
                                     is_before);
        const auto first = [&] { (*this)(left, (threads + 1) / 2); };
        const auto second = [&] { (*this)(right, std::max(threads / 2, 1u)); };
        if (threads > 1 && points.size() >= least_shared) {
            Workers(threads).side_by_side("order", first, second);
        } else {
            first();
            second();
        }
    }

private:
    std::size_t leaf_;
};

}  // namespace

std::vector<std::uint32_t> spatial_order(std::span<const Vec3f> points, std::uint32_t leaf,
                                         std::uint32_t threads,
                                         std::span<const std::uint32_t> start) {
    std::vector<Numbered> numbered(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        const std::uint32_t number = start.empty() ? i : start[i];
        const Vec3f p = points[number];
        numbered[i] = {{p.x, p.y, p.z}, number};
    }
    SpatialSort{leaf}(numbered, threads);
    std::vector<std::uint32_t> order(points.size());
    std::ranges::transform(numbered, order.begin(), &Numbered::number);
    return order;
}

}  // namespace pierce
