#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/workers.hpp"
#include "core/geometry/triangle_corners.hpp"
#include "core/geometry/triangle_pair.hpp"
#include "pierce/mesh.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

inline Vec3d middle_of(std::span<const Vec3f> positions, const Triangle& t) {
    Vec3d sum;
    for (std::uint32_t v : t.vertex) sum += to_double(positions[v]);
    return (1.0 / 3) * sum;
}

inline double area_of(std::span<const Vec3f> positions, const Triangle& t) {
    return 0.5 * length(TriangleCorners(view_of(positions), t).normal());
}

/// Where a triangle is asked about what is around it: in the middle and near each corner, since
/// something may be around an end of it only.
inline std::array<Vec3d, 4> places_of(const Corners& c) {
    constexpr double near_corner = 0.9, near_others = 0.05;
    return {(1.0 / 3) * (c[0] + c[1] + c[2]), near_corner * c[0] + near_others * (c[1] + c[2]),
            near_corner * c[1] + near_others * (c[2] + c[0]),
            near_corner * c[2] + near_others * (c[0] + c[1])};
}
inline std::array<Vec3d, 4> places_of(std::span<const Vec3f> positions, const Triangle& t) {
    return places_of(Corners{to_double(positions[t.vertex[0]]), to_double(positions[t.vertex[1]]),
                             to_double(positions[t.vertex[2]])});
}

/// Triangles by the number of their group: parts or patches of a surface.
class TriangleGroups {
public:
    TriangleGroups(std::span<const std::uint32_t> group_of, std::uint32_t groups)
        : begin_(groups + 1, 0), members_(group_of.size()) {
        for (std::uint32_t g : group_of) ++begin_[g + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
        for (std::uint32_t t = 0; t < group_of.size(); ++t) members_[next[group_of[t]]++] = t;
    }

    /// In order.
    std::span<const std::uint32_t> members(std::uint32_t group) const {
        return {members_.data() + begin_[group], members_.data() + begin_[group + 1]};
    }
    /// Calls see(triangle, its place among the members) for up to `most` of them, evenly among all.
    template <class See>
    void for_each_sample(std::uint32_t group, std::uint32_t most, const See& see) const {
        const std::span<const std::uint32_t> all = members(group);
        const std::uint64_t samples = std::min<std::uint64_t>(all.size(), most);
        for (std::uint64_t i = 0; i < samples; ++i) {
            const auto place = static_cast<std::uint32_t>(i * all.size() / samples);
            see(all[place], place);
        }
    }

private:
    std::vector<std::uint32_t> begin_, members_;
};

/// What judge(group) says of each group, asked on all threads; `what` is what progress is told.
template <class Judge>
auto judge_groups(std::string_view what, std::uint32_t groups, Workers& workers,
                  const Judge& judge) {
    using Answer = std::invoke_result_t<Judge, std::uint32_t>;
    constexpr std::uint32_t groups_at_once = 4;
    // Threads cannot write the bits of a vector<bool> side by side.
    std::vector<std::conditional_t<std::is_same_v<Answer, bool>, std::uint8_t, Answer>> answers(
        groups);
    workers.share_out(what, groups, groups_at_once, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t group = begin; group < end; ++group) answers[group] = judge(group);
    });
    return std::vector<Answer>(answers.begin(), answers.end());
}

}  // namespace pierce
