#pragma once

#include "core/device/four.hpp"
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
#if defined(PIERCE_FOUR_LANES)
        if (triangle == no_triangle) return all;
        Four lower = row(start[0]), upper = lower;
        for (const Vec3f* at : {&start[1], &start[2], &end[0], &end[1], &end[2]}) {
            lower = min_of(row(*at), lower);
            upper = max_of(row(*at), upper);
        }
        // Whole rows, whatever then is in the padding: they are read as rows again.
        lower.put(&all.lower);
        upper.put(&all.upper);
        return all;
#endif
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

#if defined(PIERCE_FOUR_LANES)
    /// A corner, and after it what lies behind it in memory.
    static Four row(const Vec3f& corner) { return Four::at(&corner); }
#endif
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
#if defined(PIERCE_FOUR_LANES)
        const auto row = [](const Vec3f& at) { return PlacedTriangle::row(at); };
        Four furthest = 0, largest = 0, motion[3], mean = 0;
        for (int k = 0; k < 3; ++k) {
            motion[k] = row(t.end[k]) - row(t.start[k]);
            mean = mean + Four(1.0f / 3) * motion[k];
            largest = max_of(abs_of(row(t.end[k]) - row(t.end[0])),
                             max_of(abs_of(row(t.start[k]) - row(t.end[0])), largest));
        }
        for (int k = 0; k < 3; ++k) furthest = max_of(abs_of(motion[k] - mean), furthest);
        drift = first_three(mean);
        corner[0].more = largest_of(first_three(furthest));
        corner[1].more = largest_of(first_three(largest));
#else
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
#endif
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
