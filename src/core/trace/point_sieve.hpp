#pragma once

#include <cstdint>
#include <limits>

#include "core/device/four.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/geometry/quick_vec3.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// The search for the triangle closest to a point, in float32: leaves out triangles and boxes that
/// are certainly further away than the closest triangle seen so far, or than a limit.
///
/// Let u be half an ulp. The point comes in two parts, so that a coordinate relative to it is off
/// by 2 u of itself, and by `pad`, which is for the rounding of the second part. Let R be the
/// largest relative coordinate of a triangle. A point of the triangle that is made up from its
/// corners is off by less than 12 u R, and so is a product of a corner with a unit vector. 32 u R
/// are taken.
class PointSieve {
public:
    PIERCE_HD PointSieve(Vec3d point, double limit, const Box& around)
        : high_(to_float(point)), low_(to_float(rest_of(point, high_))) {
        double largest = around.max_coordinate();
        for (int k = 0; k < 3; ++k) largest = max_of(std::fabs(point[k]), largest);
        pad_ = round_up(constants::point_pad * largest);
        shrink(round_up(limit));
    }

    /// Leaves out only what is beyond the limit: of what is seen, some may not count.
    PIERCE_HD void keep_limit() { shrinks_ = false; }

    /// The squared distance of a box, and whether it may hold a triangle that is close enough.
    PIERCE_HD float squared_to(Vec3f lower, Vec3f upper) const {
        const Vec3f from = relative(lower), to = relative(upper);
        const Vec3f gap = {quick_max(quick_max(from.x, -to.x), 0.0f),
                           quick_max(quick_max(from.y, -to.y), 0.0f),
                           quick_max(quick_max(from.z, -to.z), 0.0f)};
        return quick_dot(gap, gap);
    }
    PIERCE_HD bool may_hold(float squared) const { return !(squared > reach_squared_); }

    /// True if a triangle may be the closest one.
    PIERCE_HD bool may_be_closest(Vec3f v0, Vec3f v1, Vec3f v2) {
        const Vec3f a = relative(v0), b = relative(v1), c = relative(v2);
        const float lost = quick_fma(
            constants::point_rounding,
            quick_max(largest_of(a), quick_max(largest_of(b), largest_of(c))), pad_);
        const Vec3f q = closest_to_origin(a, b, c);
        const float squared = quick_dot(q, q),
                    distance = std::sqrt(squared < least_squared ? least_squared : squared);
        const float most = quick_fma(distance, 1 + constants::point_rounding, lost);
        // Triangles without area are never the closest one.
        if (shrinks_ && most < reach_ && !may_be_degenerate(v0, v1, v2)) shrink(most);
        // No point of the triangle is closer than its corners along any direction; along the way to
        // the closest point, that is how far this is away.
        const float least = quick_min(quick_dot(q, a), quick_min(quick_dot(q, b), quick_dot(q, c)));
        return !((least / distance) * (1 - constants::point_rounding) - lost > reach_);
    }

    /// The same for four triangles side by side: a bit for each.
    PIERCE_HD std::uint32_t may_be_closest(const FourVec3 (&corner)[3]) {
        const FourVec3 a = relative(corner[0]), b = relative(corner[1]), c = relative(corner[2]),
                       q = closest_to_origin(a, b, c);
        const Four lost = Four(constants::point_rounding) *
                              max_of(largest_of(a), max_of(largest_of(b), largest_of(c))) +
                          Four(pad_),
                   squared = max_of(least_squared, dot(q, q));
        std::uint32_t first = 0;
        for (std::uint32_t k = 1; k < Four::count; ++k)
            if (squared[k] < squared[first]) first = k;
        const float most = quick_fma(std::sqrt(squared[first]), 1 + constants::point_rounding,
                                     lost[first]);
        const auto of_first = [&](const FourVec3& v) {
            return Vec3f{v.x[first], v.y[first], v.z[first]};
        };
        if (shrinks_ && most < reach_ &&
            !may_be_degenerate(of_first(corner[0]), of_first(corner[1]), of_first(corner[2])))
            shrink(most);
        // With squares, as roots take long.
        const Four least = max_of(min_of(dot(q, a), min_of(dot(q, b), dot(q, c))), 0),
                   further = least * (least / squared) * Four(1 - 2 * constants::point_rounding),
                   reach = Four(reach_) + lost;
        return ~greater(further, reach * reach) & Four::all_bits;
    }

private:
    /// Of a distance; smaller ones are not rounded as others are.
    static constexpr float least_squared = std::numeric_limits<float>::min();

    /// True of every triangle for which is_degenerate() holds: in float32 the cross product is off
    /// by less than twice degenerate_area, as differences of corners are off by half an ulp.
    PIERCE_HD static bool may_be_degenerate(Vec3f a, Vec3f b, Vec3f c) {
        const Vec3f ab = b - a, bc = c - b, ca = a - c;
        const float longest = quick_max(quick_dot(ab, ab),
                                        quick_max(quick_dot(bc, bc), quick_dot(ca, ca)));
        const Vec3f n = quick_cross(ab, ca);
        const float least = static_cast<float>(4 * constants::degenerate_area) * longest;
        return !(quick_dot(n, n) > least * least);
    }

    PIERCE_HD Vec3f relative(Vec3f v) const { return (v - high_) - low_; }
    PIERCE_HD FourVec3 relative(const FourVec3& v) const {
        return (v - FourVec3::all(high_)) - FourVec3::all(low_);
    }

    /// Triangles further away than `distance` are not the closest one; NaN tells nothing.
    PIERCE_HD void shrink(float distance) {
        if (!(distance < reach_)) return;
        reach_ = distance;
        const float with_rounding = quick_fma(distance, 1 + constants::point_rounding, pad_);
        reach_squared_ = quick_fma(with_rounding, with_rounding, std::numeric_limits<float>::min());
    }

    /// The point of a triangle that is closest to the origin (Ericson 2005, 5.1.5), up to rounding;
    /// in any case a point of the triangle, or NaN.
    PIERCE_HD static Vec3f closest_to_origin(Vec3f a, Vec3f b, Vec3f c) {
        const Vec3f ab = b - a, ac = c - a;
        const float d1 = -quick_dot(ab, a), d2 = -quick_dot(ac, a), d3 = -quick_dot(ab, b),
                    d4 = -quick_dot(ac, b), d5 = -quick_dot(ab, c), d6 = -quick_dot(ac, c);
        const float va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
        float v = 0, w = 0;
        if (d1 <= 0 && d2 <= 0) {
            return a;
        } else if (d3 >= 0 && d4 <= d3) {
            return b;
        } else if (d6 >= 0 && d5 <= d6) {
            return c;
        } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
            v = d1 / (d1 - d3);
        } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
            w = d2 / (d2 - d6);
        } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
            w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            v = 1 - w;
        } else {
            const float sum = va + vb + vc;
            v = vb / sum;
            w = vc / sum;
        }
        if (!(v >= 0 && w >= 0 && v + w <= 1 + constants::point_rounding)) return a;
        return {quick_fma(w, ac.x, quick_fma(v, ab.x, a.x)),
                quick_fma(w, ac.y, quick_fma(v, ab.y, a.y)),
                quick_fma(w, ac.z, quick_fma(v, ab.z, a.z))};
    }

    /// The same for four triangles, without branches: what holds in an earlier branch is chosen
    /// last.
    PIERCE_HD static FourVec3 closest_to_origin(const FourVec3& a, const FourVec3& b,
                                                const FourVec3& c) {
        const FourVec3 ab = b - a, ac = c - a;
        const Four d1 = -dot(ab, a), d2 = -dot(ac, a), d3 = -dot(ab, b), d4 = -dot(ac, b),
                   d5 = -dot(ab, c), d6 = -dot(ac, c);
        const Four va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2,
                   sum = va + vb + vc, along_bc = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        Four v = vb / sum, w = vc / sum;
        const auto choose = [&](Four none_is_positive, Four then_v, Four then_w) {
            const Four positive = std::numeric_limits<float>::min();
            v = where(none_is_positive, positive, then_v, v);
            w = where(none_is_positive, positive, then_w, w);
        };
        choose(max_of(va, max_of(d3 - d4, d6 - d5)), Four(1) - along_bc, along_bc);
        choose(max_of(vb, max_of(-d2, d6)), 0, d2 / (d2 - d6));
        choose(max_of(vc, max_of(-d1, d3)), d1 / (d1 - d3), 0);
        choose(max_of(-d6, d5 - d6), 0, 1);
        choose(max_of(-d3, d4 - d3), 1, 0);
        choose(max_of(d1, d2), 0, 0);
        // At the first corner if the weights are none, or NaN.
        const auto keep_if_less = [&](Four x, Four than) {
            v = where(x, than, v, 0);
            w = where(x, than, w, 0);
        };
        keep_if_less(-v, std::numeric_limits<float>::min());
        keep_if_less(-w, std::numeric_limits<float>::min());
        keep_if_less(v + w, 1 + constants::point_rounding);
        return a + ab * v + ac * w;
    }

    Vec3f high_, low_;
    bool shrinks_ = true;
    float pad_ = 0;
    float reach_ = std::numeric_limits<float>::infinity();
    float reach_squared_ = std::numeric_limits<float>::infinity();
};

}  // namespace pierce
