#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scenes/aimed_rays.hpp"

namespace pierce::scenes {

/// Rays aimed at vertices or edges from inside a closed mesh, and how many of them slipped out.
struct LeakCount {
    double offset = 0;   ///< of the mesh from the origin, along all axes [length]
    std::string kernel;  ///< the triangle test
    bool fma = false;    ///< products and sums contracted, as compilers do unless told not to
    Aim aim = Aim::vertices;
    std::size_t rays = 0, leaks = 0;

    double share() const {
        return rays > 0 ? static_cast<double>(leaks) / static_cast<double>(rays) : 0;
    }
};

/// The library's tracer, from exact rays in double, in a ball of radius 1.
LeakCount count_tracer_leaks(double offset, Aim aim, std::size_t rays);

/// Single triangle tests, all from the same float32 rays, in a ball of radius 16 rounded to
/// float32. No rays where rounding has crushed the ball.
std::vector<LeakCount> count_kernel_leaks(double offset, Aim aim, std::size_t rays);

/// Offsets to look at: 0 and 2^0 to 2^24.
std::vector<double> leak_offsets();

}  // namespace pierce::scenes
