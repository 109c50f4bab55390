#pragma once

#include <limits>

#include "core/device/four.hpp"
#include "core/step/sheets/four_triangles.hpp"
#include "core/step/sheets/placed_triangle.hpp"
#include "core/step/sheets/quick_triangle.hpp"
#include "pierce/constants.hpp"

#if defined(PIERCE_FOUR_LANES)

/// DriftingPair for four pairs at once: the same formulas with the same bounds, a lane each.
namespace pierce::stages {

/// What is known of four pairs; a bit for each.
struct FourCompanies {
    std::uint32_t separate = 0, distant = 0;

    std::uint32_t settled() const { return separate & distant; }
    void learn(const FourCompanies& more) {
        separate |= more.separate;
        distant |= more.distant;
    }
};

/// Four pairs of triangles, as culling sees them.
class FourDriftingPairs {
public:
    FourDriftingPairs(const FourTriangles& a, const FourTriangles& b) {
        Four a_stray = 0, b_stray = 0, own = 0;
        const FourVec3 origin = a.corner(0, a_stray);
        a1_ = a.corner(1, a_size_) - origin;
        a2_ = a.corner(2, own) - origin;
        b_[0] = b.corner(0, b_stray) - origin;
        b_[1] = b.corner(1, b_size_) - origin;
        b_[2] = b.corner(2, own) - origin;
        drift_ = b.drift(own) - a.drift(own);
        stray_ = a_stray + b_stray;
        const Four size = max_of(a_size_, largest_of(b_[0]) + b_size_);
        constexpr float infinite = std::numeric_limits<float>::infinity();
        size_ = where(constants::quick_smallest, size,
                      where(size, constants::quick_largest, size, infinite), infinite);
    }

    FourCompanies along_normal_of_a(Four margin) const {
        const FourVec3 n = cross(a1_, a2_);
        return across(n, quick_dot(n, b_[0]), quick_dot(n, b_[1]), quick_dot(n, b_[2]),
                      quick_dot(n, drift_), a_size_, margin);
    }
    FourCompanies along_normal_of_b(Four margin) const {
        const FourVec3 n = cross(b_[1] - b_[0], b_[2] - b_[0]);
        const Four at = quick_dot(n, b_[0]);
        return across(n, -at, quick_dot(n, a1_) - at, quick_dot(n, a2_) - at, -quick_dot(n, drift_),
                      b_size_, margin);
    }
    FourCompanies along_middles(Four margin) const {
        const FourVec3 n = b_[0] + b_[1] + b_[2] - a1_ - a2_;
        const Four n_sum = sum_of_sizes(n),
                   made_up = Four(constants::quick_rounding) * n_sum * size_;
        const Four ahead = least(quick_dot(n, b_[0]), quick_dot(n, b_[1]), quick_dot(n, b_[2])) -
                           max_of(max_of(quick_dot(n, a1_), quick_dot(n, a2_)), 0);
        const Four before = ahead - quick_dot(n, drift_) - n_sum * stray_;
        const std::uint32_t telling = greater(n_sum, Four(constants::quick_rounding) * size_);
        return {telling & greater(min_of(before, ahead), made_up),
                telling & beyond(margin, ahead - made_up, n)};
    }

private:
    static Four least(Four p, Four q, Four r) { return min_of(p, min_of(q, r)); }
    static std::uint32_t beyond(Four margin, Four ahead, FourVec3 n) {
        return greater(ahead, 0) & greater(ahead * ahead, margin * margin * quick_dot(n, n));
    }

    FourCompanies across(FourVec3 n, Four p, Four q, Four r, Four way, Four size_of_other,
                         Four margin) const {
        const Four n_sum = sum_of_sizes(n), off = n_sum * stray_;
        const Four made_up = Four(constants::quick_rounding) * n_sum * size_ +
                             Four(constants::quick_normal_rounding) * size_of_other *
                                 size_of_other * size_of_other;
        const Four ahead = least(p, q, r), behind = -max_of(p, max_of(q, r));
        const Four ahead_before = ahead - way - off, behind_before = behind + way - off;
        return {
            greater(max_of(min_of(ahead_before, ahead), min_of(behind_before, behind)), made_up),
            beyond(margin, max_of(ahead, behind) - made_up, n)};
    }

    FourVec3 a1_{}, a2_{}, b_[3], drift_{};
    Four stray_{}, a_size_{}, b_size_{}, size_{};
};

}  // namespace pierce::stages

#endif
