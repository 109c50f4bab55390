#include "core/partition/space_partition.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "pierce/box.hpp"

namespace pierce {
namespace {

class Bisection {
public:
    Bisection(std::span<const WeightedPoint> points, std::span<const double> shares)
        : points_(points), shares_(shares), parts_(points.size(), 0) {}

    std::vector<std::uint32_t> run() {
        std::vector<std::uint32_t> all(points_.size());
        std::iota(all.begin(), all.end(), 0u);
        cut(all, 0, static_cast<std::uint32_t>(shares_.size()));
        return std::move(parts_);
    }

private:
    /// Gives some points to the parts [first, last).
    void cut(std::span<std::uint32_t> some, std::uint32_t first, std::uint32_t last) {
        if (last - first <= 1) {
            for (const std::uint32_t p : some) parts_[p] = first;
            return;
        }
        const std::uint32_t middle = first + (last - first) / 2;
        const double below = sum(first, middle), above = sum(middle, last);
        sort_along(longest_axis(some), some);
        double left = 0;
        for (const std::uint32_t p : some) left += points_[p].weight;
        const double wanted = below + above > 0 ? left * below / (below + above) : 0;
        std::size_t at = 0;
        for (double taken = 0; at < some.size(); ++at) {
            const double weight = points_[some[at]].weight;
            if (taken + 0.5 * weight > wanted) break;
            taken += weight;
        }
        cut(some.first(at), first, middle);
        cut(some.subspan(at), middle, last);
    }

    double sum(std::uint32_t first, std::uint32_t last) const {
        return std::accumulate(shares_.begin() + first, shares_.begin() + last, 0.0);
    }

    int longest_axis(std::span<const std::uint32_t> some) const {
        Box box;
        for (const std::uint32_t p : some) box.extend(points_[p].at);
        const Vec3d size = box.upper - box.lower;
        int longest = 0;
        for (int axis = 1; axis < 3; ++axis)
            if (size[axis] > size[longest]) longest = axis;
        return longest;
    }

    void sort_along(int axis, std::span<std::uint32_t> some) const {
        std::ranges::sort(some, [&](std::uint32_t p, std::uint32_t q) {
            return std::pair(points_[p].at[axis], p) < std::pair(points_[q].at[axis], q);
        });
    }

    std::span<const WeightedPoint> points_;
    std::span<const double> shares_;
    std::vector<std::uint32_t> parts_;
};

}  // namespace

std::vector<std::uint32_t> divide_space(std::span<const WeightedPoint> points,
                                        std::span<const double> shares) {
    return Bisection(points, shares).run();
}

}  // namespace pierce
