#pragma once

#include <cmath>
#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/closest_search.hpp"
#include "core/trace/surface_walk.hpp"

/// What a triangle near a point says about the point, without a ray and without a search.
namespace pierce::stages {

/// The place of a point over or under the plane of a triangle.
struct OverTriangle {
    double weight[3];  ///< barycentrics of the point of the plane right below or above
    double height;     ///< [length] negative behind the triangle
    Vec3d foot;        ///< the point of the plane right below or above

    PIERCE_HD OverTriangle(Vec3d point, Vec3d a, Vec3d b, Vec3d c) {
        const Vec3d normal = cross(b - a, c - a), p = point - a;
        const double squared = length_squared(normal);
        weight[1] = dot(normal, cross(p, c - a)) / squared;
        weight[2] = dot(normal, cross(b - a, p)) / squared;
        weight[0] = 1 - weight[1] - weight[2];
        height = dot(normal, p) / std::sqrt(squared);
        foot = point - (dot(normal, p) / squared) * normal;
    }

    /// True if the point of the plane lies in the triangle.
    PIERCE_HD bool is_above() const { return weight[0] > 0 && weight[1] > 0 && weight[2] > 0; }

    /// True if the triangle is certainly the closest one to the point.
    PIERCE_HD bool is_closest(const BodyView& body, std::uint32_t triangle) const {
        return is_only_near(body.mesh.rings[triangle], weight, std::fabs(height), body.deviation,
                            body.touch);
    }

    /// [length] How far the other triangles are from the point right below or above at least, in
    /// the rest shape.
    PIERCE_HD double to_others(const BodyView& body, std::uint32_t triangle) const {
        const TriangleRing& ring = body.mesh.rings[triangle];
        return min_of(static_cast<double>(ring.gap), ring_distance(ring, weight));
    }
};

/// A look at a point near a simple target, from one of the target's triangles. If the other
/// triangles are further from the point right below or above than the point itself is, there is
/// nothing on the way to it: the side of the triangle tells whether the point is inside. It tells
/// nothing within two touch tolerances.
struct Look {
    enum Seen : std::uint8_t {
        nothing,
        inside,   ///< and the closest point of the target is on the triangle
        outside,  ///< and stays so until it has moved by `free`
    };
    Seen seen = nothing;
    double free = 0;  ///< [length]
    Vec3d closest;
    double depth = 0;  ///< [length] from the point to the closest one
    Vec3d corner[3];

    PIERCE_HD Look(const BodyView& target, std::uint32_t triangle, Vec3d point, double touch) {
        const Surface surface = target.surface();
        const Triangle& t = surface.triangles[triangle];
        for (int k = 0; k < 3; ++k) corner[k] = to_double(surface.positions[t.vertex[k]]);
        const OverTriangle over(point, corner[0], corner[1], corner[2]);
        if (over.height > 0) {
            free = min_of(over.height, over.to_others(target, triangle) - over.height) - 2 * touch;
            if (free > 0 && over.is_above() && !is_degenerate(corner[0], corner[1], corner[2]))
                seen = outside;
            return;
        }
        if (!(over.height < -2 * touch) || !over.is_closest(target, triangle) ||
            is_degenerate(corner[0], corner[1], corner[2]))
            return;
        // As closest_point() has it of a point above the inside of a triangle.
        closest = in_box_of(over.foot, corner[0], corner[1], corner[2]);
        depth = length(closest - point);
        seen = inside;
    }
};

}  // namespace pierce::stages
