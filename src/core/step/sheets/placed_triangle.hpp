#pragma once

#include "core/device/quick_math.hpp"
#include "core/geometry/grid_boxes.hpp"
#include "core/geometry/quick_vec3.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"
#include "pierce/ids.hpp"

namespace pierce::stages {

/// A triangle during the step, in world space.
struct PlacedTriangle {
    Vec3f start[3], end[3];
    std::uint32_t triangle = no_triangle;  ///< no_triangle: its group has no more triangles, or its
                                           ///< body takes no part
    std::uint32_t own = 0;                 ///< TriangleFeatures::own

    PIERCE_HD QuickBox box() const {
        QuickBox all;
        for (int c = 0; c < 3 && triangle != no_triangle; ++c) {
            all.extend(start[c]);
            all.extend(end[c]);
        }
        return all;
    }
    PIERCE_HD Vec3d end_normal() const {
        const Vec3d a = to_double(end[0]);
        return cross(to_double(end[1]) - a, to_double(end[2]) - a);
    }
};

/// A placed triangle as most of culling sees it: its corners at the end of the step, and their mean
/// motion. This is less to read and tells hardly less, because a triangle turns and stretches
/// little over a step.
struct alignas(16) DriftingTriangle {
    struct Corner {
        Vec3f end;
        float more = 0;
    };

    Corner corner[3];
    Vec3f drift;            ///< the mean of its corners' motions
    std::uint32_t own = 0;  ///< TriangleFeatures::own

    DriftingTriangle() = default;
    PIERCE_HD explicit DriftingTriangle(const PlacedTriangle& t)
        : corner{{t.end[0]}, {t.end[1]}, {t.end[2]}}, own(t.own) {
        float furthest = 0, largest = 0;
        Vec3f motion[3];
        for (int k = 0; k < 3; ++k) {
            motion[k] = t.end[k] - t.start[k];
            drift += (1.0f / 3) * motion[k];
            largest = quick_max(largest_of(t.end[k] - t.end[0]),
                                quick_max(largest_of(t.start[k] - t.end[0]), largest));
        }
        for (int k = 0; k < 3; ++k) furthest = quick_max(largest_of(motion[k] - drift), furthest);
        corner[0].more = furthest;
        corner[1].more = largest;
    }

    /// An upper bound of how far a coordinate of a corner's motion is from that of the mean motion.
    PIERCE_HD float stray() const { return corner[0].more; }
    /// An upper bound of the corners' coordinates, at the start and at the end, relative to the
    /// first corner's place at the end.
    PIERCE_HD float size() const { return corner[1].more; }
    PIERCE_HD Vec3f end_normal() const {
        return quick_cross(corner[1].end - corner[0].end, corner[2].end - corner[0].end);
    }
};

}  // namespace pierce::stages
