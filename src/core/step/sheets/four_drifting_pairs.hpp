#pragma once

#include <limits>

#include "core/device/four.hpp"
#include "core/step/sheets/placed_triangle.hpp"
#include "core/step/sheets/quick_triangle.hpp"
#include "pierce/constants.hpp"

#if defined(PIERCE_FOUR_LANES)

/// DriftingPair for four other triangles at once: the same formulas with the same bounds, a lane
/// each.
namespace pierce::stages {

/// What is known of four pairs; a bit for each.
struct FourCompanies {
    std::uint32_t separate = 0, distant = 0;

    static constexpr std::uint32_t all = (1u << Four::count) - 1;

    std::uint32_t settled() const { return separate & distant; }
    void learn(const FourCompanies& more) {
        separate |= more.separate;
        distant |= more.distant;
    }
};

/// A triangle and four others, as culling sees them.
class FourDriftingPairs {
public:
    FourDriftingPairs(const DriftingTriangle& a, const DriftingTriangle* const (&b)[Four::count])
        : a1_(FourVec3::all(a.corner[1].end - a.corner[0].end)),
          a2_(FourVec3::all(a.corner[2].end - a.corner[0].end)),
          a_size_(a.size()) {
        const FourVec3 origin = FourVec3::all(a.corner[0].end);
        Four stray = 0, own = 0;
        b_[0] = gather(b, 0, stray) - origin;
        b_[1] = gather(b, 1, b_size_) - origin;
        b_[2] = gather(b, 2, own) - origin;
        drift_ = gather(b, 3, own) - FourVec3::all(a.drift);
        stray_ = Four(a.stray()) + stray;
        const Four size = max_of(a_size_, largest_of(b_[0]) + b_size_);
        constexpr float infinite = std::numeric_limits<float>::infinity();
        size_ = where(constants::quick_smallest, size,
                      where(size, constants::quick_largest, size, infinite), infinite);
    }

    FourCompanies along_normal_of_a(float margin) const {
        const FourVec3 n = cross(a1_, a2_);
        return across(n, quick_dot(n, b_[0]), quick_dot(n, b_[1]), quick_dot(n, b_[2]),
                      quick_dot(n, drift_), a_size_, margin);
    }
    FourCompanies along_normal_of_b(float margin) const {
        const FourVec3 n = cross(b_[1] - b_[0], b_[2] - b_[0]);
        const Four at = quick_dot(n, b_[0]);
        return across(n, -at, quick_dot(n, a1_) - at, quick_dot(n, a2_) - at, -quick_dot(n, drift_),
                      b_size_, margin);
    }
    FourCompanies along_middles(float margin) const {
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
    /// Sixteen bytes of each triangle: corner `row`, or after the corners the drift.
    static FourVec3 gather(const DriftingTriangle* const (&b)[Four::count], int row, Four& after) {
        const void* at[Four::count];
        for (std::uint32_t k = 0; k < Four::count; ++k)
            at[k] = reinterpret_cast<const unsigned char*>(b[k]) + 16 * row;
        return FourVec3::gathered(at, after);
    }
    static Four least(Four p, Four q, Four r) { return min_of(p, min_of(q, r)); }
    static std::uint32_t beyond(float margin, Four ahead, FourVec3 n) {
        return greater(ahead, 0) & greater(ahead * ahead, Four(margin * margin) * quick_dot(n, n));
    }

    FourCompanies across(FourVec3 n, Four p, Four q, Four r, Four way, Four size_of_other,
                         float margin) const {
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

    FourVec3 a1_, a2_, b_[3], drift_ = {};
    Four stray_ = 0, a_size_, b_size_ = 0, size_ = 0;
};

}  // namespace pierce::stages

#endif
