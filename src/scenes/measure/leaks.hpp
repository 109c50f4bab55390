#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scenes/measure/aimed_rays.hpp"

namespace pierce::scenes {

/// Rays aimed at vertices or edges from inside a closed mesh, and how many of them slipped out.
struct LeakCount {
    double offset = 0;   ///< of the mesh from the origin, along all axes [length]
    std::string kernel;  ///< the triangle test
    bool fma = false;    ///< products and sums are contracted, as compilers do by default
    Aim aim = Aim::vertices;
    std::size_t rays = 0, leaks = 0;

    double share() const {
        return rays > 0 ? static_cast<double>(leaks) / static_cast<double>(rays) : 0;
    }
};

/// Counts leaks of the library's tracer, with exact rays in double, in a ball of radius 1.
LeakCount count_tracer_leaks(double offset, Aim aim, std::size_t rays);

/// Counts leaks of single triangle tests, all with the same float32 rays, in a ball of radius 16
/// rounded to float32. Where rounding has crushed the ball, there are no rays.
std::vector<LeakCount> count_kernel_leaks(double offset, Aim aim, std::size_t rays);

/// The offsets that are measured: 0 and 2^0 to 2^24.
std::vector<double> leak_offsets();

}  // namespace pierce::scenes
