#pragma once

#include "core/device/quick_math.hpp"
#include "core/geometry/quick_vec3.hpp"
#include "core/geometry/triangle.hpp"
#include "core/trace/ray.hpp"
#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"

namespace pierce {

/// A ray in float32, for triangles: leaves out those that cross_triangle() certainly does not meet.
///
/// Let u be half an ulp and no coordinate relative to the origin be above R. With the origin in two
/// parts, a difference is off by 3 u R. A sheared difference is below 2 R and off by 10 u R, as
/// shears are at most 1. A product of two such differences is off by 44 u R^2, and an edge function
/// by 96 u R^2.
class TriangleSieve {
public:
    PIERCE_HD explicit TriangleSieve(const Ray& ray) {
        const ShearedRay exact(ray.origin, ray.direction);
        axis_ = exact.axis;
        shear_x_ = static_cast<float>(exact.shear_x);
        shear_y_ = static_cast<float>(exact.shear_y);
        high_ = to_float(ray.origin);
        low_ = to_float(rest_of(ray.origin, high_));
    }

    /// For a leaf with these corners: bit k says that triangle k may be crossed.
    PIERCE_HD std::uint32_t may_cross(Vec3f v0, Vec3f v1, Vec3f v2, Vec3f v3) const {
        float size = 0;
        const Vec3f a = sheared(v0, size), b = sheared(v1, size), c = sheared(v2, size),
                    d = sheared(v3, size);
        if (!(size > constants::quick_smallest)) return 3;
        const float shared = edge(c, b), made_up = constants::quick_rounding * size * size;
        return std::uint32_t{may_cross(shared, edge(a, c), edge(b, a), made_up)} |
               std::uint32_t{may_cross(-shared, edge(d, b), edge(c, d), made_up)} << 1;
    }

    /// The same for a triangle.
    PIERCE_HD bool may_cross(Vec3f v0, Vec3f v1, Vec3f v2) const {
        float size = 0;
        const Vec3f a = sheared(v0, size), b = sheared(v1, size), c = sheared(v2, size);
        return !(size > constants::quick_smallest) ||
               may_cross(edge(c, b), edge(a, c), edge(b, a),
                         constants::quick_rounding * size * size);
    }

private:
    PIERCE_HD static float edge(Vec3f a, Vec3f b) { return a.x * b.y - a.y * b.x; }

    PIERCE_HD static bool may_cross(float u, float v, float w, float made_up) {
        return !(quick_min(u, quick_min(v, w)) < -made_up &&
                 quick_max(u, quick_max(v, w)) > made_up);
    }

    /// Where a point lies, seen along the ray. `size` grows to its largest coordinate relative to
    /// the origin.
    PIERCE_HD Vec3f sheared(Vec3f point, float& size) const {
        const Vec3f v = (point - high_) - low_;
        size = quick_max(quick_max(std::fabs(v.x), std::fabs(v.y)),
                         quick_max(std::fabs(v.z), size));
        const float x = axis_ == 2 ? v.x : axis_ == 1 ? v.z : v.y;
        const float y = axis_ == 2 ? v.y : axis_ == 1 ? v.x : v.z;
        const float z = axis_ == 2 ? v.z : axis_ == 1 ? v.y : v.x;
        return {x - shear_x_ * z, y - shear_y_ * z, z};
    }

    Vec3f high_, low_;
    float shear_x_, shear_y_;
    int axis_;
};

}  // namespace pierce
