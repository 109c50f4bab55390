#pragma once

#include <limits>

#include "core/geometry/triangle.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/ray.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// True if a ray with these `excluded` vertices does not hit the triangle.
PIERCE_HD inline bool is_excluded(const Triangle& t, const std::uint32_t (&excluded)[2]) {
    return has_vertex(t, excluded[0]) && has_vertex(t, excluded[1]);
}

/// The search for a ray's way through a surface. A tracer shows it triangles in any order through
/// test(). The triangle found depends neither on that order nor on triangles shown in vain.
///
/// Meaning of the result (first_crossing below): crossings within `touch` of the ray's origin are
/// its start. If they lead out of the surface, the origin touches the surface from inside and that
/// triangle is the hit; if they lead in, they do not count. Next, the search takes the first window
/// [t, t + touch] whose signed crossings do not cancel: the net sign of the window decides, and the
/// triangle of that sign with the smallest id is the hit. Windows that cancel are grazed edges and
/// coincident sheets. A ray with a `t_min` has no start: crossings up to `t_min` do not count. If
/// the ray has an `outward` and the answer does not lead out, the search also takes the last
/// crossing behind the start, at most `outward` away. If that crossing leads out along the ray, it
/// is the hit, marked as predicted.
///
/// Of a surface whose parts overlap (Surface::covered), the solid is their union: the search sums
/// up all crossings of the ray, which is the winding number at its origin. If that is 1 or more,
/// the hit is the crossing behind which it is 0; otherwise, if the origin does not touch, it is the
/// first one that leads in. A ray with a `t_min` meets such a surface as any other.
class CrossingSearch {
public:
    PIERCE_HD CrossingSearch(const Ray& ray, const Surface& surface)
        : surface_(surface), ray_(ray.origin, ray.direction), t_max_(ray.t_max) {
        excluded_[0] = ray.excluded[0];
        excluded_[1] = ray.excluded[1];
        outward_ = ray.outward;
        first_pass_ = !(ray.t_min > 0);
        joins_parts_ = surface.covered.size > 0 && first_pass_;
        if (joins_parts_) outward_ = 0;
        touch_ = ray.touch;
        after_ = first_pass_ ? touch_ : ray.t_min;
    }

    /// Triangles beyond this need not be shown any more. It only shrinks.
    PIERCE_HD double limit() const { return min_of(reach(), nearest_) + touch_; }
    /// Triangles before this need not be shown.
    PIERCE_HD double begin() const { return first_pass_ ? -max_of(outward_, touch_) : after_; }

    PIERCE_HD void test(std::uint32_t triangle) {
        const Triangle& t = surface_.triangles[triangle];
        if (is_excluded(t, excluded_)) return;
        const Vec3d a = to_double(surface_.positions[t.vertex[0]]);
        const Vec3d b = to_double(surface_.positions[t.vertex[1]]);
        const Vec3d c = to_double(surface_.positions[t.vertex[2]]);
        const Crossing crossing = cross_triangle(ray_, a, b, c);
        if (crossing.kind == Crossing::none) return;
        if (crossing.kind == Crossing::coplanar) {
            if (first_pass_ && touches_triangle(ray_.origin, a, b, c, touch_))
                coplanar_ = min_of(triangle, coplanar_);
            return;
        }
        if (crossing.t <= after_) {
            if (!first_pass_) return;
            if (crossing.t >= -touch_)
                start_.add(triangle, crossing.sign, crossing_share(ray_, a, b, c, crossing));
            else if (crossing.t >= -outward_)
                look_behind(triangle, crossing);
            return;
        }
        if (crossing.t > reach() + touch_) return;
        if (summing_) {
            if (crossing.t <= nearest_ + touch_)
                window_.add(triangle, crossing.sign, crossing_share(ray_, a, b, c, crossing));
            return;
        }
        const bool clean = crossing.weight[0] > 0 && crossing.weight[1] > 0 &&
                           crossing.weight[2] > 0;
        if (crossing.t < nearest_) {
            second_ = nearest_;
            nearest_ = crossing.t;
            nearest_triangle_ = triangle;
            nearest_clean_ = clean;
            nearest_exit_ = crossing.sign > 0;
        } else {
            second_ = min_of(crossing.t, second_);
        }
    }

    /// Decides what to do after all triangles between begin() and limit() were shown: true to show
    /// them all again, false if hit() is the answer. Nearly all rays meet one clean crossing and
    /// need no second look.
    PIERCE_HD bool again() {
        if (first_pass_) {
            first_pass_ = false;
            touching_ = coplanar_ != no_triangle                      ? coplanar_
                        : start_.weight >= constants::crossing_weight ? start_.exit
                                                                      : no_triangle;
            if (touching_ != no_triangle && !joins_parts_) return settle(touching_, true);
        }
        if (!summing_) {
            if (nearest_triangle_ == no_triangle) return end();
            if (nearest_clean_ && second_ > nearest_ + touch_)
                return take(nearest_triangle_,
                            nearest_exit_ ? 2 * constants::half_turn : -2 * constants::half_turn);
            summing_ = true;
            window_ = {};
            return true;
        }
        if (window_.weight >= constants::crossing_weight) return take(window_.exit, window_.weight);
        if (window_.weight <= -constants::crossing_weight)
            return take(window_.entry, window_.weight);
        grazed_ = true;
        return go_on(nearest_ + touch_);
    }

    PIERCE_HD Hit hit() const { return hit_; }

private:
    /// Signed crossings of one window, and the triangle with the smallest id of either sign.
    struct Window {
        std::int64_t weight = 0;
        std::uint32_t exit = no_triangle, entry = no_triangle;

        PIERCE_HD void add(std::uint32_t triangle, double sign, std::int64_t share) {
            weight += sign > 0 ? share : -share;
            if (sign > 0)
                exit = min_of(triangle, exit);
            else
                entry = min_of(triangle, entry);
        }
    };

    /// How far crossings count.
    PIERCE_HD double reach() const {
        return joins_parts_ && winding_ == 0 ? std::numeric_limits<double>::infinity() : t_max_;
    }

    /// A window that does not cancel.
    PIERCE_HD bool take(std::uint32_t triangle, std::int64_t weight) {
        if (!joins_parts_) return settle(triangle, weight > 0);
        left_ += weight;
        if (weight < 0 && entered_ == no_triangle && nearest_ <= t_max_ + touch_)
            entered_ = triangle;
        if (winding_ > 0 && left_ > winding_ - constants::crossing_weight)
            return settle(triangle, true);
        return go_on(nearest_ + touch_);
    }

    /// There is no crossing any more.
    PIERCE_HD bool end() {
        if (!joins_parts_ || winding_ > 0) return settle(no_triangle, false);
        if (left_ < constants::crossing_weight) {
            const bool touches = touching_ != no_triangle;
            return settle(touches ? touching_ : entered_, touches);
        }
        winding_ = left_;
        left_ = 0;
        grazed_ = false;
        return go_on(touch_);
    }

    PIERCE_HD bool go_on(double after) {
        after_ = after;
        summing_ = false;
        nearest_ = second_ = std::numeric_limits<double>::infinity();
        nearest_triangle_ = no_triangle;
        return true;
    }

    /// Notes a crossing behind the origin, if it is the last one so far.
    PIERCE_HD void look_behind(std::uint32_t triangle, const Crossing& crossing) {
        if (crossing.t < behind_ || (crossing.t == behind_ && triangle > behind_triangle_)) return;
        behind_ = crossing.t;
        behind_triangle_ = triangle;
        behind_exit_ = crossing.sign > 0;
    }

    PIERCE_HD bool settle(std::uint32_t triangle, bool exit) {
        hit_ = {triangle, false, grazed_};
        if (!exit && behind_exit_) hit_ = {behind_triangle_, true, grazed_};
        return false;
    }

    Surface surface_;
    ShearedRay ray_;
    std::uint32_t excluded_[2];
    double t_max_ = 0;
    double touch_ = 0;
    double after_ = 0;
    double nearest_ = std::numeric_limits<double>::infinity();
    double second_ = std::numeric_limits<double>::infinity();
    std::uint32_t nearest_triangle_ = no_triangle;
    std::uint32_t coplanar_ = no_triangle;
    Hit hit_;
    Window start_, window_;
    double outward_ = 0;
    double behind_ = -std::numeric_limits<double>::infinity();
    std::uint32_t behind_triangle_ = no_triangle;
    std::uint32_t touching_ = no_triangle;
    // Of a surface whose parts overlap: the first entry, what the windows so far add up to, and
    // what all of them do, once that is known.
    std::uint32_t entered_ = no_triangle;
    std::int64_t left_ = 0, winding_ = 0;
    bool joins_parts_ = false;
    bool behind_exit_ = false;
    bool nearest_clean_ = false;
    bool nearest_exit_ = false;
    bool first_pass_;
    bool summing_ = false;
    bool grazed_ = false;
};

/// How a ray's line meets a triangle of the surface.
PIERCE_HD inline Crossing crossing_of(const Ray& ray, const Surface& surface,
                                      std::uint32_t triangle) {
    const TriangleCorners at = surface.corners(triangle);
    return cross_triangle({ray.origin, ray.direction}, at.a, at.b, at.c);
}

/// True if the ray leaves the surface through `triangle`, or lies in it.
PIERCE_HD inline bool leads_out(const Ray& ray, const Surface& surface, std::uint32_t triangle) {
    const Crossing crossing = crossing_of(ray, surface, triangle);
    return crossing.kind == Crossing::coplanar || crossing.sign > 0;
}

/// True if the ray lies in the plane of `triangle`.
PIERCE_HD inline bool lies_in(const Ray& ray, const Surface& surface, std::uint32_t triangle) {
    return crossing_of(ray, surface, triangle).kind == Crossing::coplanar;
}

/// The triangle through which a ray first crosses a surface, or none. `show(search)` calls
/// search.test() for every triangle the ray may meet between search.begin() and search.limit().
template <class Show>
PIERCE_HD Hit first_crossing(const Ray& ray, const Surface& surface, Show show) {
    CrossingSearch search(ray, surface);
    do show(search);
    while (search.again());
    return search.hit();
}

}  // namespace pierce
