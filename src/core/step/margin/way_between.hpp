#pragma once

#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"
#include "pierce/vec3.hpp"

namespace pierce::stages {

/// The way that two edges have between them if they are closest to each other between their ends:
/// at right angles to both.
class WayBetween {
public:
    /// From the edge between `a0` and `a1` to the one between `b0` and `b1`. `largest`: of all
    /// coordinates.
    PIERCE_HD WayBetween(Vec3d a0, Vec3d a1, Vec3d b0, Vec3d b1, double largest) {
        const Vec3d a = a1 - a0, b = b1 - b0;
        way_ = cross(a, b);
        squared_ = length_squared(way_);
        const double along = dot(way_, b0 - a0), least = constants::touch_tolerance * largest;
        distance_squared_ = along * along;
        is_known_ = distance_squared_ > least * least * squared_ &&
                    squared_ > constants::edges_sine * constants::edges_sine * length_squared(a) *
                                   length_squared(b);
        if (!(along > 0)) way_ = -way_;
    }

    /// The way back, of edges that have passed each other.
    PIERCE_HD WayBetween reversed() const {
        WayBetween back = *this;
        back.way_ = -way_;
        return back;
    }

    /// Below the angle and the distance from which on rounding does not decide.
    PIERCE_HD bool is_known() const { return is_known_; }
    /// True if it is certainly longer than `most`.
    PIERCE_HD bool is_longer_than(double most) const {
        return distance_squared_ > (1 + 2 * constants::way_slack) * most * most * squared_;
    }
    /// True if it certainly leads to the side of a triangle on which `over` is, seen from an edge
    /// of the triangle that it begins or, for a `sign` of -1, ends at: by more than `touch` for a
    /// unit vector.
    PIERCE_HD bool leads_over(Vec3d over, double sign, double touch) const {
        const double height = sign * dot(way_, over),
                     slack = constants::way_slack * constants::way_slack * length_squared(over) +
                             touch * touch;
        return height > 0 && height * height > 2 * slack * squared_;
    }

private:
    Vec3d way_;                                  // as long as the cross product of both edges
    double squared_ = 0, distance_squared_ = 0;  // of the way, and of the distance times the way
    bool is_known_ = false;
};

}  // namespace pierce::stages
