#pragma once

#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"
#include "pierce/min_max.hpp"
#include "pierce/vec3.hpp"

/// What a fixed direction proves about two convex features whose four corners move in straight
/// lines.
///
/// Along a fixed direction n, the difference d(t) = n . (x(t) - y(t)) of two corners is linear in
/// time. While d is positive for every corner x of the first feature and every corner y of the
/// second, d is positive for all their convex combinations, and the features do not meet. For each
/// pair of corners, the time at which d stops being positive follows from its values at two times.
namespace pierce::separating {

/// The four corners at one time, relative to one of them: those of the first feature, then those of
/// the second.
struct Corners {
    Vec3d at[4];
};

PIERCE_HD inline Vec3d between(Vec3d start, Vec3d end, double t) {
    return start + t * (end - start);
}

PIERCE_HD inline Corners between(const Corners& start, const Corners& end, double t) {
    Corners now;
    for (int k = 0; k < 4; ++k) now.at[k] = between(start.at[k], end.at[k], t);
    return now;
}

/// The largest absolute coordinate.
PIERCE_HD inline double size_of(const Corners& corners) {
    double size = 0;
    for (int k = 0; k < 4; ++k)
        for (int axis = 0; axis < 3; ++axis) size = max_of(std::fabs(corners.at[k][axis]), size);
    return size;
}

/// True if a coordinate axis separates features with `firsts` and 4 - `firsts` corners from time 0
/// to 1. `size`: no coordinate is larger.
template <int firsts>
PIERCE_HD bool axis_separates(const Corners& start, const Corners& end, double size) {
    const double error = constants::motion_rounding * size;
    for (int axis = 0; axis < 3; ++axis) {
        bool above = true, below = true;
        for (int i = 0; i < firsts; ++i)
            for (int j = firsts; j < 4; ++j) {
                const double s = start.at[i][axis] - start.at[j][axis],
                             e = end.at[i][axis] - end.at[j][axis];
                above &= s > error && e > error;
                below &= s < -error && e < -error;
            }
        if (above || below) return true;
    }
    return false;
}

/// The time up to which `n` is known to separate two features, the first feature ahead; `t` if `n`
/// does not separate them, 2 if it separates them to the end. The features are at `now` at time `t`
/// and at `end` at time 1.
template <int firsts>
PIERCE_HD double separated_until(const Corners& now, const Corners& end, double t, Vec3d n,
                                 double size) {
    // u = 2^-53, coordinates up to the size s, |n| = |n.x| + |n.y| + |n.z|. The rounding errors
    // are: 1 u s for a corner relative to another; 20 u s for a corner of a part of a feature,
    // whose weights are exact; 6 u s for its place at a time between; 56 u s for the difference of
    // two such places; 8 u s for the dot product. The time found is wrong by less than 4 u, while d
    // changes by 4 |n| s per unit of time at most: 16 u s. The sum is 80 |n| u s, and `error` is
    // 128 |n| u s.
    const double error = constants::motion_rounding *
                         (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z)) * size;
    double from[4], to[4];
    for (int k = 0; k < 4; ++k) {
        from[k] = dot(n, now.at[k]);
        to[k] = dot(n, end.at[k]);
    }
    double share = 2;
    for (int i = 0; i < firsts; ++i)
        for (int j = firsts; j < 4; ++j) {
            const double s = from[i] - from[j] - error, e = to[i] - to[j] - error;
            if (!(s > 0)) return t;
            if (!(e > 0)) share = min_of(s / (s - e), share);
        }
    return share > 1 ? share : t + share * (1 - t);
}

}  // namespace pierce::separating
