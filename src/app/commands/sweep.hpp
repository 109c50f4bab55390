#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace pierce::app {

struct SweepOptions {
    std::filesystem::path file;
    std::uint32_t jobs = 1;             ///< runs at the same time
    std::optional<std::uint32_t> only;  ///< the number of one run; none: all that are missing
    bool list = false;                  ///< print the missing runs, and run nothing
    bool slurm = false;                 ///< print a script for Slurm, and run nothing
};

/// Runs what is missing of a sweep as processes, and gathers one table. Returns the exit code: 1 if
/// a run has failed.
int sweep(const SweepOptions& options);

}  // namespace pierce::app
