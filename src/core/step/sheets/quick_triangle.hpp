#pragma once

#include <limits>

#include "core/device/quick_math.hpp"
#include "core/geometry/quick_vec3.hpp"
#include "core/step/sheets/sheet_bounds.hpp"
#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"

/// What float32 proves about triangles of sheets during a step. It settles nearly all pairs of
/// triangles.
namespace pierce::stages {

/// A point during the step, float32, relative to some place near it.
struct QuickPoint {
    Vec3f start, end;
};

/// How far some points reach along a direction, at the start of the step and at its end.
struct Reach {
    float low[2] = {}, high[2] = {};

    template <int count>
    PIERCE_HD Reach(Vec3f n, const QuickPoint (&points)[count]) {
        for (int k = 0; k < count; ++k) {
            const float at[2] = {quick_dot(n, points[k].start), quick_dot(n, points[k].end)};
            for (int when = 0; when < 2; ++when) {
                low[when] = k == 0 ? at[when] : quick_min(at[when], low[when]);
                high[when] = k == 0 ? at[when] : quick_max(at[when], high[when]);
            }
        }
    }
};

/// What is known about two features, or two triangles, during a step.
struct Company {
    bool separate = false;  ///< they do not meet during the step
    bool distant = false;   ///< at the end of the step they are no contact, unless they have met:
                            ///< they are too far apart, or not over each other

    PIERCE_HD bool is_settled() const { return separate && distant; }
    PIERCE_HD void learn(const Company& more) {
        separate |= more.separate;
        distant |= more.distant;
    }
};

/// `size`, if float32 can prove something about things of that size; infinite otherwise, which
/// makes all bounds of rounding errors infinite. With coordinates up to s, heights over a triangle,
/// times twice its area, are below 48 s^3, and is_beyond() squares them.
PIERCE_HD inline float telling_size(float size) {
    return size > constants::quick_smallest && size < constants::quick_largest
               ? size
               : std::numeric_limits<float>::infinity();
}

/// An upper bound of the error of float32 in coordinates along `n`. `size`: no coordinate is
/// larger.
PIERCE_HD inline float made_up_along(Vec3f n, float size) {
    return constants::quick_rounding * sum_of_sizes(n) * size;
}

/// True if something that is `ahead` along `n`, of any length, is further away than `margin`. It
/// avoids a square root, which takes long.
PIERCE_HD inline bool is_beyond(float margin, float ahead, Vec3f n) {
    return ahead > 0 && ahead * ahead > margin * margin * quick_dot(n, n);
}

/// What a direction `n`, of any length, says about two convex things with these reaches along it.
/// Differences of corners are linear in time, so a thing stays ahead if it is ahead at the start
/// and at the end.
PIERCE_HD inline Company company_along(Vec3f n, const Reach& of_a, const Reach& of_b, float margin,
                                       float size) {
    const float made_up = made_up_along(n, size);
    const float ahead = of_a.low[1] - of_b.high[1], behind = of_b.low[1] - of_a.high[1];
    return {quick_max(quick_min(of_a.low[0] - of_b.high[0], ahead),
                      quick_min(of_b.low[0] - of_a.high[0], behind)) > made_up,
            is_beyond(margin, quick_max(ahead, behind) - made_up, n)};
}

template <int mine, int others>
PIERCE_HD Company company_along(Vec3f n, const QuickPoint (&a)[mine], const QuickPoint (&b)[others],
                                float margin, float size) {
    return company_along(n, Reach(n, a), Reach(n, b), margin, size);
}

/// Two triangles as culling sees them, and what their normals say about them.
class DriftingPair {
public:
    PIERCE_HD DriftingPair(const DriftingTriangle& a, const DriftingTriangle& b)
        : a1_(a.corner[1].end - a.corner[0].end),
          a2_(a.corner[2].end - a.corner[0].end),
          drift_(b.drift - a.drift),
          stray_(a.stray() + b.stray()),
          a_size_(a.size()),
          b_size_(b.size()) {
        for (int k = 0; k < 3; ++k) b_[k] = b.corner[k].end - a.corner[0].end;
        size_ = telling_size(quick_max(a.size(), largest_of(b_[0]) + b.size()));
    }

    PIERCE_HD Company along_normal_of_a(float margin) const {
        const Vec3f n = quick_cross(a1_, a2_);
        return across(n, quick_dot(n, b_[0]), quick_dot(n, b_[1]), quick_dot(n, b_[2]),
                      quick_dot(n, drift_), a_size_, margin);
    }
    PIERCE_HD Company along_normal_of_b(float margin) const {
        const Vec3f n = quick_cross(b_[1] - b_[0], b_[2] - b_[0]);
        const float at = quick_dot(n, b_[0]);
        return across(n, -at, quick_dot(n, a1_) - at, quick_dot(n, a2_) - at, -quick_dot(n, drift_),
                      b_size_, margin);
    }

    /// What follows along the line between the middles. It keeps apart what lies side by side in
    /// one plane, where the normals tell nothing. Let u be half an ulp, S be size_ and N be the sum
    /// of n's sizes. Corners are off by u S, so that heights along n are off by 4 u N S each and
    /// their difference by 10 u N S. In each triangle a motion is below 2 S and off by 2 u S, and
    /// its difference from the mean one by 4 u S more; the difference of the means is below 4 S and
    /// off by 4 u S more, and the sum of the strays below 8 S and off by 8 u S. That is 24 u N S
    /// along n; the products with n add 12 and 24 u N S, and the last differences 20 u N S: 90 in
    /// all, where quick_rounding takes 128. A shorter n proves nothing, as products with it may
    /// come near the smallest float32.
    PIERCE_HD Company along_middles(float margin) const {
        const Vec3f n = between_middles();
        const float n_sum = sum_of_sizes(n), made_up = constants::quick_rounding * n_sum * size_;
        const float ahead = quick_min(quick_dot(n, b_[0]),
                                      quick_min(quick_dot(n, b_[1]), quick_dot(n, b_[2]))) -
                            quick_max(0, quick_max(quick_dot(n, a1_), quick_dot(n, a2_)));
        const float before = ahead - quick_dot(n, drift_) - n_sum * stray_;
        if (!(n_sum > constants::quick_rounding * size_)) return {};
        return {quick_min(before, ahead) > made_up, is_beyond(margin, ahead - made_up, n)};
    }

    /// The line between the middles, three times as long.
    PIERCE_HD Vec3f between_middles() const { return b_[0] + b_[1] + b_[2] - a1_ - a2_; }

private:
    /// What follows from the heights `p`, `q` and `r` of one triangle's corners over the plane of
    /// the other, whose normal is `n`, and from the `way` along `n` that it has come. Up to
    /// rounding, the other triangle's corners lie in the plane. Let u be half an ulp. For a
    /// triangle with coordinates up to the size s, differences of corners are off by u s and their
    /// cross product by 3 u s^2 more, so that the corners reach 9 u s^3 + |n| u s along it. Their
    /// places relative to another corner, up to S away, are off by 3 |n| u S. Heights lose less
    /// than what quick_rounding has to spare.
    PIERCE_HD Company across(Vec3f n, float p, float q, float r, float way, float size_of_other,
                             float margin) const {
        const float n_sum = sum_of_sizes(n), off = n_sum * stray_;
        const float made_up = constants::quick_rounding * n_sum * size_ +
                              constants::quick_normal_rounding * size_of_other * size_of_other *
                                  size_of_other;
        const float ahead = quick_min(p, quick_min(q, r)), behind = -quick_max(p, quick_max(q, r));
        const float ahead_before = ahead - way - off, behind_before = behind + way - off;
        return {
            quick_max(quick_min(ahead_before, ahead), quick_min(behind_before, behind)) > made_up,
            is_beyond(margin, quick_max(ahead, behind) - made_up, n)};
    }

    Vec3f a1_, a2_, b_[3];  ///< at the end of the step, relative to the first corner of a
    Vec3f drift_;           ///< of b, relative to a
    float stray_, a_size_, b_size_, size_ = 0;
};

/// A triangle during the step, float32, relative to `origin`.
struct QuickTriangle {
    QuickPoint corner[3];

    QuickTriangle() = default;
    PIERCE_HD QuickTriangle(const PlacedTriangle& t, Vec3f origin) {
        for (int k = 0; k < 3; ++k) corner[k] = {t.start[k] - origin, t.end[k] - origin};
    }
    PIERCE_HD Vec3f start_normal() const {
        return quick_cross(corner[1].start - corner[0].start, corner[2].start - corner[0].start);
    }
    PIERCE_HD Vec3f end_normal() const {
        return quick_cross(corner[1].end - corner[0].end, corner[2].end - corner[0].end);
    }
    /// An upper bound of the coordinates at the start of the step, or at its end.
    PIERCE_HD float start_size() const {
        float size = 0;
        for (const QuickPoint& p : corner)
            for (int axis = 0; axis < 3; ++axis) size = quick_max(std::fabs(p.start[axis]), size);
        return size;
    }
    PIERCE_HD float end_size() const {
        float size = 0;
        for (const QuickPoint& p : corner)
            for (int axis = 0; axis < 3; ++axis) size = quick_max(std::fabs(p.end[axis]), size);
        return size;
    }
    /// Corner k, without indexing by a value known only at run time: arrays indexed so do not stay
    /// in registers.
    PIERCE_HD QuickPoint pick(std::uint32_t k) const {
        return k == 0 ? corner[0] : k == 1 ? corner[1] : corner[2];
    }
};

}  // namespace pierce::stages
