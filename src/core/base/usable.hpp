#pragma once

#include <span>
#include <string>

#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "pierce/host_device.hpp"
#include "pierce/pose.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// True if no coordinate is NaN or beyond constants::largest_coordinate.
template <class T>
PIERCE_HD bool is_within_reach(Vec3<T> p) {
    const T most = static_cast<T>(constants::largest_coordinate);
    bool within = true;
    for (int k = 0; k < 3; ++k) within = within && p[k] <= most && p[k] >= -most;
    return within;
}

/// True if a mesh with this box is no point, but squares of differences are nothing in float32.
inline bool is_too_small(const Box& box) {
    return box.extent() > 0 && box.extent() < 1 / constants::largest_coordinate;
}

/// True if a body can be there: the position is within reach, and the quaternion is a rotation.
PIERCE_HD inline bool is_usable(const Pose& pose) {
    const Quaternion& q = pose.rotation;
    const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    return is_within_reach(pose.position) && norm >= constants::smallest_rotation &&
           norm <= constants::largest_rotation;
}

/// Throws InputError, beginning with `subject`, unless every position is within reach.
inline void check_positions(const std::string& subject, std::span<const Vec3f> positions) {
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (!is_within_reach(positions[v]))
            throw InputError(subject + ": vertex " + std::to_string(v) +
                             (is_finite(positions[v]) ? " is too far away" : " is not finite"));
}

}  // namespace pierce
