#pragma once

#include "pierce/host_device.hpp"
#include "pierce/min_max.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// The place [0..1] on the segment from `a` along `ab` that is closest to `p`; 0 if the segment is
/// a point.
PIERCE_HD inline double closest_place_on_segment(Vec3d p, Vec3d a, Vec3d ab) {
    const double size = length_squared(ab);
    return size > 0 ? clamp_to(dot(p - a, ab) / size, 0.0, 1.0) : 0.0;
}

/// Places along two segments [0..1].
struct SegmentPlaces {
    double first = 0, second = 0;
};

/// Where the segment from `a0` to `a1` and the one from `b0` to `b1` are closest (Ericson 2005,
/// 5.1.9). The distance of these places is the smallest one up to a few roundings of the
/// coordinates, however small the angle. Segments may be parallel, or points.
PIERCE_HD inline SegmentPlaces closest_points_of_segments(Vec3d a0, Vec3d a1, Vec3d b0, Vec3d b1) {
    const Vec3d a = a1 - a0, b = b1 - b0, n = cross(a, b);
    const double size = length_squared(n);
    SegmentPlaces places;
    // With cross products, an angle x between the lines makes the place wrong by a rounding divided
    // by x. This changes its distance from the other line by one rounding. Differences of dot
    // products lose twice as many digits.
    if (size > 0) places.first = clamp_to(dot(cross(b0 - a0, b), n) / size, 0.0, 1.0);
    places.second = closest_place_on_segment(a0 + places.first * a, b0, b);
    places.first = closest_place_on_segment(b0 + places.second * b, a0, a);
    return places;
}

}  // namespace pierce
