#pragma once

#include "pierce/box.hpp"
#include "pierce/pose.hpp"

namespace pierce {

/// An upper bound of how far a point of `box` moves when the frame of `box` goes from one place to
/// another. It is the way of the box's centre, plus what the rotation moves the rest by. The
/// operator norm of the difference of two rotations is their Frobenius distance over the root of
/// two.
PIERCE_HD inline double largest_motion(const Frame& from, const Frame& to, const Box& box) {
    double squared = 0;
    for (int r = 0; r < 3; ++r)
        squared += length_squared(to.rotation.row[r] - from.rotation.row[r]);
    const Vec3d c = box.center();
    return length(to.to_parent(c) - from.to_parent(c)) +
           std::sqrt(0.5 * squared) * 0.5 * box.extent();
}

}  // namespace pierce
