#pragma once

#include "pierce/core/constants.hpp"
#include "pierce/core/float_rules.hpp"
#include "pierce/core/quick_vec3.hpp"
#include "pierce/core/stages/sheet_bounds.hpp"

/// What float32 says for certain about triangles of sheets during a step. Nearly all pairs of them are settled so.
namespace pierce::stages {

/// What is known of how two features, or two triangles, get along.
struct Company {
    bool separate = false;  ///< they do not meet during the step
    bool distant = false;   ///< at its end they are no contact, unless they have met: too far apart, or not over each other

    PIERCE_HD bool is_settled() const { return separate && distant; }
    PIERCE_HD void learn(const Company& more) {
        separate |= more.separate;
        distant |= more.distant;
    }
};

/// How much of what is said along `n` float32 may have made up. `size`: no coordinate is larger.
PIERCE_HD inline float made_up_along(Vec3f n, float size) {
    return constants::quick_rounding * (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z)) * size;
}

/// True if something `ahead` along `n`, of any length, is further away than `margin`. Roots take long.
PIERCE_HD inline bool is_beyond(float margin, float ahead, Vec3f n) {
    return ahead > 0 && ahead * ahead > margin * margin * quick_dot(n, n);
}

/// What a direction `n`, of any length, says about two convex things that reach so far along it: differences of corners are
/// linear in time, so that one stays ahead if it is ahead at the start and at the end.
PIERCE_HD inline Company company_along(Vec3f n, const Reach& of_a, const Reach& of_b, float margin, float size) {
    const float made_up = made_up_along(n, size);
    const float ahead = of_a.low[1] - of_b.high[1], behind = of_b.low[1] - of_a.high[1];
    return {quick_max(quick_min(of_a.low[0] - of_b.high[0], ahead), quick_min(of_b.low[0] - of_a.high[0], behind)) > made_up,
            is_beyond(margin, quick_max(ahead, behind) - made_up, n)};
}

template <int mine, int others>
PIERCE_HD Company company_along(Vec3f n, const QuickPoint (&a)[mine], const QuickPoint (&b)[others], float margin,
                                float size) {
    return company_along(n, Reach(n, a), Reach(n, b), margin, size);
}

/// A triangle during the step, and how it faces.
struct FacingTriangle {
    PlacedTriangle placed;
    Facing facing;
};

/// What the normal of one of two triangles says about them.
PIERCE_HD inline Company company_along_normal(const FacingTriangle& one, const FacingTriangle& two, float margin) {
    const PlacedTriangle &t = one.placed, &other = two.placed;
    const Vec3f n = one.facing.normal;
    const Vec3f apart = other.end[0] - t.end[0];
    const float between = quick_max(std::fabs(apart.x), quick_max(std::fabs(apart.y), std::fabs(apart.z)));
    QuickPoint corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = {other.start[k] - t.end[0], other.end[k] - t.end[0]};
    return company_along(n, one.facing.reach, Reach(n, corner), margin,
                         quick_max(one.facing.size, between + two.facing.size));
}

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
    PIERCE_HD Vec3f end_normal() const { return quick_cross(corner[1].end - corner[0].end, corner[2].end - corner[0].end); }
    /// No coordinate is larger at the start of the step, or at its end.
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
    /// A corner without an index that only the running thread knows: such arrays do not stay in registers.
    PIERCE_HD QuickPoint pick(std::uint32_t k) const { return k == 0 ? corner[0] : k == 1 ? corner[1] : corner[2]; }
};

}  // namespace pierce::stages
