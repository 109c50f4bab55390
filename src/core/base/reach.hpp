#pragma once

#include <cmath>
#include <span>
#include <string>

#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// True if no coordinate is NaN or beyond constants::largest_coordinate.
template <class T>
bool is_within_reach(Vec3<T> p) {
    const T most = static_cast<T>(constants::largest_coordinate);
    return std::fabs(p.x) <= most && std::fabs(p.y) <= most && std::fabs(p.z) <= most;
}

/// Throws InputError unless every position is within reach.
inline void check_positions(const std::string& name, std::span<const Vec3f> positions) {
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (!is_within_reach(positions[v]))
            throw InputError("'" + name + "': vertex " + std::to_string(v) +
                             (is_finite(positions[v]) ? " is too far away" : " is not finite"));
}

}  // namespace pierce
