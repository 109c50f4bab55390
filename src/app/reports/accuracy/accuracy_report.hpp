#pragma once

#include <cstdint>
#include <filesystem>

#include "app/measure/motion.hpp"

namespace pierce::app {

struct AccuracyReportOptions {
    std::filesystem::path out;
    std::filesystem::path html;      ///< the one file; empty: report.html in that folder
    std::uint32_t count = 100;       ///< falling bodies of the scenes
    Timing timing{9, 1.0 / 60};      ///< of the scenes
    std::uint32_t every = 9;         ///< the scenes' truth is made for every Nth frame
    std::uint32_t poses = 400;       ///< random poses per pair of meshes; half of it per ratio of
                                     ///< resolutions
    std::uint32_t rays = 1'000'000;  ///< at holes of the library's tracer; a fiftieth of it at
                                     ///< those of each triangle test
    std::uint32_t seed = 1;
    int threads = 1;  ///< for rays
};

/// Measures how wrong each method is, and how long it takes, against exact truth, and writes one
/// page, report.md, and for each experiment a CSV file and, if matplotlib is installed, an SVG
/// picture. Returns the exit code; throws InputError if the folder cannot be written or
/// pierce_truth is missing.
int report_accuracy(const AccuracyReportOptions& options);

}  // namespace pierce::app
