#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/vec3.hpp"

namespace pierce {

/// What a partition is made of: a place in space, and how much work is there.
struct WeightedPoint {
    Vec3d at;
    double weight = 1;
};

/// Divides points into parts that are compact and have the wanted shares of all weights, as nearly
/// as whole points allow: recursive coordinate bisection (Berger and Bokhari 1987), always across
/// the longest side. Returns each point's part. The same points give the same parts on every
/// machine. Takes n log^2 n time.
std::vector<std::uint32_t> divide_space(std::span<const WeightedPoint> points,
                                        std::span<const double> shares);

}  // namespace pierce
