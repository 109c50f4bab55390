#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "core/device/four.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/geometry/quick_vec3.hpp"
#include "core/mesh/surface.hpp"
#include "pierce/constants.hpp"

/// How far a segment is from triangles at least: four at a time, in float32.
namespace pierce::stages {

/// Lower bounds of the distances between the segment from `a` to `b` and a few triangles of a
/// surface [length]. A bound is zero if segment and triangle meet, nearly meet, or lie in one
/// plane. It looks along the directions that separate a segment and a triangle (Gottschalk, Lin and
/// Manocha 1996): the triangle's normal, the products of its sides with the segment, and across
/// each side in the triangle's plane.
class SegmentGaps {
public:
    static constexpr std::uint32_t count = Four::count;

    PIERCE_HD SegmentGaps(Vec3d a, Vec3d b, const Surface& surface,
                          const std::uint32_t (&triangle)[count]) {
        const Vec3f middle = to_float(0.5 * (a + b)), half = to_float(0.5 * (b - a));
        lost_ = round_up(length(rest_of(0.5 * (a + b), middle)));
        FourVec3 corner[3];  // relative to the middle
        for (std::uint32_t k = 0; k < count; ++k)
            for (int c = 0; c < 3; ++c) {
                const Vec3f at = surface.positions[surface.triangles[triangle[k]].vertex[c]] -
                                 middle;
                corner[c].x.set(k, at.x);
                corner[c].y.set(k, at.y);
                corner[c].z.set(k, at.z);
            }
        measure({half.x, half.y, half.z}, corner);
    }

    PIERCE_HD double operator[](std::uint32_t k) const { return static_cast<double>(gap_[k]); }

private:
    /// Coordinates are divided by the largest one of their triangle and the segment, so that no
    /// product overflows. Then, with sides of size s and half a segment of size h [largest
    /// coordinate], rounding loses of a projection along a side's product with the segment less
    /// than 2^-18 h s, along the normal 2^-17 s^2, and across a side 2^-15 s^3: each is the sum of
    /// the roundings of up to 256 products, by half an ulp each. Sixteen times that is subtracted.
    /// If anything is left, the direction is so long that its own rounding makes it shorter by 3 %
    /// at most. Four ulp more are for the coordinates.
    PIERCE_HD void measure(FourVec3 half, const FourVec3 (&corner)[3]) {
        const Four size = max_of(max_of(largest_of(corner[0]), largest_of(corner[1])),
                                 max_of(largest_of(corner[2]), largest_of(half))),
                   unit = Four(1) / size;
        const FourVec3 h = half * unit,
                       v[3] = {corner[0] * unit, corner[1] * unit, corner[2] * unit},
                       side[3] = {v[1] - v[0], v[2] - v[1], v[0] - v[2]},
                       normal = cross(side[0], side[1]);
        const Four longest = max_of(max_of(largest_of(side[0]), largest_of(side[1])),
                                    largest_of(side[2])),
                   reach = largest_of(h);
        Four squared = 0;
        const auto look = [&](FourVec3 along, Four gap, Four lost) {
            const Four left = max_of(gap - lost, 0);
            squared = max_of(left * left / (dot(along, along) + std::numeric_limits<float>::min()),
                             squared);
        };
        look(normal, abs_of(dot(normal, v[0])) - abs_of(dot(normal, h)),
             Four(constants::gap_lost_normal) * longest * longest);
        for (int c = 0; c < 3; ++c) {
            const FourVec3 across = cross(h, side[c]), outward = cross(side[c], normal);
            const Four at_side = dot(across, v[c]), at_corner = dot(across, v[c == 0 ? 2 : c - 1]);
            look(across, max_of(min_of(at_side, at_corner), -max_of(at_side, at_corner)),
                 Four(constants::gap_lost_product) * reach * longest);
            look(outward, -dot(outward, v[c]) - abs_of(dot(outward, h)),
                 Four(constants::gap_lost_side) * longest * longest * longest);
        }
        for (std::uint32_t k = 0; k < count; ++k) {
            const float gap = size[k] * ((1 - constants::gap_lost_length) * std::sqrt(squared[k]) -
                                         constants::gap_lost_coordinates) -
                              lost_;
            gap_[k] = gap > 0 ? gap : 0.0f;  // NaN tells nothing
        }
    }

    float lost_ = 0;  ///< [length] by rounding the middle
    float gap_[count];
};

}  // namespace pierce::stages
