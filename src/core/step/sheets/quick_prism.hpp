#pragma once

#include "core/device/quick_math.hpp"
#include "core/step/sheets/quick_triangle.hpp"

/// Cheap tests in float32 of whether features may be close; they err on the side of "may be".
namespace pierce::stages {

/// An upper bound of the error of float32 in a product of four lengths. Let u be half an ulp and no
/// coordinate be above `size`. Differences of coordinates are below 2 size and off by 4 u size;
/// their cross product is below 8 size^2 and off by 48 u size^2; the cross product of that with
/// another difference is below 32 size^3 and off by 320 u size^3; and the dot product with one more
/// difference is off by 2600 u size^4.
PIERCE_HD inline float made_up_of_four(float size) {
    return constants::quick_product_rounding * (size * size) * (size * size);
}

/// An upper bound of the error of float32 in heights along `n`, the cross product of two edges,
/// over a plane that holds both of them, or of two parallel planes that hold one each. Let u be
/// half an ulp. To what made_up_along() takes, this adds what the edges themselves reach along `n`,
/// which is all that `n` says about parallel edges: a coordinate of `n` is off by 48 u size^2, and
/// the coordinates of an edge are below 2 size. That is 288 u size^3 for each edge.
PIERCE_HD inline float made_up_across(Vec3f n, float size) {
    return made_up_along(n, size) + constants::quick_common_normal_rounding * (size * size * size);
}

/// True if some points are certainly further ahead of some others along `n` than `margin` [length].
/// Let u be half an ulp. Each coordinate is off by u size, a dot product by 3 u size times the sum
/// of n's sizes more, a difference of two by 2 u size: 10 u size in all, where made_up_along()
/// takes 128 u. A shorter `n` proves nothing, as products with it may come near the smallest
/// float32.
template <int mine, int others>
PIERCE_HD bool is_past(Vec3f n, const Vec3f (&points)[mine], const Vec3f (&behind)[others],
                       float margin, float size) {
    const float telling = telling_size(size);
    float low = quick_dot(n, points[0]), high = quick_dot(n, behind[0]);
    for (int k = 1; k < mine; ++k) low = quick_min(quick_dot(n, points[k]), low);
    for (int k = 1; k < others; ++k) high = quick_max(quick_dot(n, behind[k]), high);
    return sum_of_sizes(n) > constants::quick_rounding * telling &&
           is_beyond(margin, low - high - made_up_along(n, telling), n);
}

/// The space over and under a triangle at the end of the step, as far as `margin` [length].
struct QuickPrism {
    Vec3f at[3], normal, inward[3];
    float margin = 0, size = 0, made_up = 0, made_up_height = 0;
    bool hides_places = false;  ///< places along its sides may be made up by rounding

    PIERCE_HD QuickPrism(Vec3f a, Vec3f b, Vec3f c, float reach, float largest)
        : at{a, b, c}, normal(quick_cross(b - a, c - a)), margin(reach), size(largest) {
        for (int k = 0; k < 3; ++k) inward[k] = quick_cross(normal, at[k == 2 ? 0 : k + 1] - at[k]);
        made_up = made_up_of_four(size);
        made_up_height = made_up_across(normal, size);
        hides_places = !(quick_dot(normal, normal) > constants::quick_hidden * made_up);
    }

    /// False if a point is outside for certain.
    PIERCE_HD bool may_hold(Vec3f p) const {
        return !(quick_dot(inward[0], p - at[0]) < -made_up) &&
               !(quick_dot(inward[1], p - at[1]) < -made_up) &&
               !(quick_dot(inward[2], p - at[2]) < -made_up) &&
               !is_beyond(margin, std::fabs(quick_dot(normal, p - at[0])) - made_up_height,
                          normal) &&
               !(hides_places && is_past(p - at[0], {p}, at, margin, size));
    }
};

/// True if one of two nearly parallel segments, or a short and a long one, is further away than
/// `margin` [length]: what is beside the longer one lies ahead across it.
PIERCE_HD inline bool are_far_beside(Vec3f p, Vec3f q, Vec3f r, Vec3f s, float margin, float size) {
    const Vec3f d = q - p, e = s - r, way = r - p;
    const float dd = quick_dot(d, d), ee = quick_dot(e, e);
    return ee > dd ? is_past(e * (quick_dot(e, way) / ee) - way, {p, q}, {r, s}, margin, size)
                   : is_past(way - d * (quick_dot(d, way) / dd), {r, s}, {p, q}, margin, size);
}

/// False if the closest points of two segments' lines are certainly not within both segments, or
/// certainly further apart than `margin` [length].
PIERCE_HD inline bool may_cross_over(Vec3f p, Vec3f q, Vec3f r, Vec3f s, float margin, float size) {
    const Vec3f d = q - p, e = s - r, n = quick_cross(d, e), way = r - p;
    const float made_up = made_up_of_four(size);
    // The place along the first, times |n|^2, is way . (e x n); one less if `way` comes from the
    // second end. The place along the second is way . (d x n).
    const Vec3f beside_e = quick_cross(e, n), beside_d = quick_cross(d, n);
    if (quick_dot(way, beside_e) < -made_up || quick_dot(r - q, beside_e) > made_up ||
        quick_dot(way, beside_d) < -made_up || quick_dot(s - p, beside_d) > made_up ||
        is_beyond(margin, std::fabs(quick_dot(n, way)) - made_up_across(n, size), n))
        return false;
    if (quick_dot(n, n) > constants::quick_hidden * made_up) return true;
    // Rounding hides those places.
    return !are_far_beside(p, q, r, s, margin, size);
}

}  // namespace pierce::stages
