#pragma once

#include "pierce/core/constants.hpp"
#include "pierce/core/float_rules.hpp"
#include "pierce/core/ray.hpp"
#include "pierce/core/triangle.hpp"

namespace pierce::bvh {

/// A ray in float32, for triangles: leaves out those that cross_triangle() does not meet for certain.
///
/// Let u be half an ulp and no coordinate relative to the origin be above R. With the origin in two parts a difference is
/// off by 3 u R; sheared, it is below 2 R and off by 10 u R, as shears are at most 1; a product of two such is off by
/// 44 u R^2, and an edge function by 96 u R^2.
class TriangleSieve {
public:
    PIERCE_HD explicit TriangleSieve(const Ray& ray) {
        const ShearedRay exact(ray.origin, ray.direction);
        axis_ = exact.axis;
        shear_x_ = static_cast<float>(exact.shear_x);
        shear_y_ = static_cast<float>(exact.shear_y);
        high_ = to_float(ray.origin);
        low_ = to_float(ray.origin - to_double(high_));
    }

    PIERCE_HD bool may_cross(Vec3f v0, Vec3f v1, Vec3f v2) const {
        float size = 0;
        const Vec3f p = sheared(v0, size), q = sheared(v1, size), r = sheared(v2, size);
        if (!(size > constants::quick_smallest)) return true;
        const float u = r.x * q.y - r.y * q.x, v = p.x * r.y - p.y * r.x, w = q.x * p.y - q.y * p.x;
        const float made_up = constants::quick_rounding * size * size;
        return !(quick_min(u, quick_min(v, w)) < -made_up && quick_max(u, quick_max(v, w)) > made_up);
    }

private:
    /// Where a point lies, seen along the ray. `size` grows to its largest coordinate relative to the origin.
    PIERCE_HD Vec3f sheared(Vec3f point, float& size) const {
        const Vec3f v = (point - high_) - low_;
        size = quick_max(quick_max(std::fabs(v.x), std::fabs(v.y)), quick_max(std::fabs(v.z), size));
        const float x = axis_ == 2 ? v.x : axis_ == 1 ? v.z : v.y;
        const float y = axis_ == 2 ? v.y : axis_ == 1 ? v.x : v.z;
        const float z = axis_ == 2 ? v.z : axis_ == 1 ? v.y : v.x;
        return {x - shear_x_ * z, y - shear_y_ * z, z};
    }

    Vec3f high_, low_;
    float shear_x_, shear_y_;
    int axis_;
};

}  // namespace pierce::bvh
