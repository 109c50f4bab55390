#pragma once

#include <cmath>

#include "core/geometry/closest_point.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/first_crossing.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// The point of the box around a triangle that is closest to `q`.
PIERCE_HD inline Vec3d in_box_of(Vec3d q, Vec3d a, Vec3d b, Vec3d c) {
    for (int k = 0; k < 3; ++k)
        q[k] = clamp_to(q[k], min_of(a[k], min_of(b[k], c[k])), max_of(a[k], max_of(b[k], c[k])));
    return q;
}

/// The point of a surface's triangle that is closest to `p`. Rounding does not carry it out of the
/// triangle's box, so no box around the triangle is further from `p` than this point, to the last
/// bit.
PIERCE_HD inline Vec3d closest_point(Vec3d p, const Surface& surface, std::uint32_t triangle) {
    const TriangleCorners at = surface.corners(triangle);
    return in_box_of(closest_on_triangle(p, at.a, at.b, at.c), at.a, at.b, at.c);
}

/// Distance from `p` to a triangle of the surface.
PIERCE_HD inline double distance_to(Vec3d p, const Surface& surface, std::uint32_t triangle) {
    return length(p - closest_point(p, surface, triangle));
}

/// True if a way leads behind a triangle's plane by more than the touch tolerance.
PIERCE_HD inline bool leads_into(Vec3d way, const Surface& surface, std::uint32_t triangle) {
    return dot(normalized(surface.corners(triangle).normal()), way) < -surface.touch;
}

/// True if the corners lie in the plane of a triangle, but for the touch tolerance.
PIERCE_HD inline bool lies_in_plane(const TriangleCorners& corners, const Surface& surface,
                                    std::uint32_t triangle) {
    const TriangleCorners of = surface.corners(triangle);
    const Vec3d normal = normalized(of.normal());
    const auto lies_in = [&](Vec3d p) { return std::fabs(dot(normal, p - of.a)) <= surface.touch; };
    return lies_in(corners.a) && lies_in(corners.b) && lies_in(corners.c);
}

/// The search for the triangle of a surface that is closest to a point and no further away than a
/// limit; of equally close ones, the one with the smallest id. Triangles that other parts of the
/// surface cover do not count, and those without area do not: what lies on one of them lies on its
/// neighbours, too, and these have a normal.
class ClosestSearch {
public:
    PIERCE_HD ClosestSearch(Vec3d point, const Surface& surface, double limit)
        : point_(point), surface_(surface), limit_(limit) {}

    /// Leaves out triangles in the planes of these two, and those to which the way leads into one
    /// of the two by more than the touch tolerance, unless it is much shorter than the limit.
    PIERCE_HD void keep_out_of(const std::uint32_t (&triangles)[2]) {
        kept_out_[0] = triangles[0];
        kept_out_[1] = triangles[1];
        short_ = constants::ridge_share * limit_;
    }

    PIERCE_HD void test(std::uint32_t triangle) {
        if (surface_.covered.size > 0 && surface_.covered[triangle] == Cover::wholly) return;
        const Vec3d way = closest_point(point_, surface_, triangle) - point_;
        const double distance = length(way);
        if (!(distance < limit_ || (distance == limit_ && triangle < triangle_))) return;
        const TriangleCorners at = surface_.corners(triangle);
        for (const std::uint32_t other : kept_out_)
            if (other != no_triangle && ((distance > short_ && leads_into(way, surface_, other)) ||
                                         lies_in_plane(at, surface_, other)))
                return;
        if (is_degenerate(at.a, at.b, at.c)) return;
        limit_ = distance;
        triangle_ = triangle;
    }

    /// True if a triangle that is left out may be closer than the one that is found. A sieve must
    /// not let it hide others.
    PIERCE_HD bool may_leave_out() const {
        return surface_.covered.size > 0 || kept_out_[0] != no_triangle;
    }

    PIERCE_HD Vec3d point() const { return point_; }
    PIERCE_HD const Surface& surface() const { return surface_; }
    /// Triangles further away than this need not be tested; those exactly as far must be.
    PIERCE_HD double limit() const { return limit_; }
    /// Closest of those tested, or no_triangle.
    PIERCE_HD std::uint32_t triangle() const { return triangle_; }

private:
    Vec3d point_;
    Surface surface_;
    double limit_ = 0, short_ = 0;
    std::uint32_t triangle_ = no_triangle;
    std::uint32_t kept_out_[2] = {no_triangle, no_triangle};
};

/// The triangle closest to a ray's origin, t_max away at most, or none. `show(search)` calls
/// search.test() for every triangle that is no further away than search.limit().
template <class Show>
PIERCE_HD std::uint32_t closest_triangle(const Ray& ray, const Surface& surface, Show show) {
    if (!(ray.t_max >= 0)) return no_triangle;
    ClosestSearch search(ray.origin, surface, ray.t_max);
    search.keep_out_of(ray.excluded);
    show(search);
    return search.triangle();
}

}  // namespace pierce
