#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace pierce::app {

/// One of a sweep's runs.
struct SweepRun {
    std::uint32_t number = 0;
    std::vector<std::string> values;     ///< of the parameters, as text
    std::vector<std::string> arguments;  ///< of `pierce`, without where results go
    std::filesystem::path folder;

    std::filesystem::path result() const { return folder / "result.json"; }
    std::filesystem::path motion() const { return folder / "motion"; }
    /// The methods' time and error on the run's motion.
    std::filesystem::path comparison() const { return folder / "comparison.json"; }
    /// What has ended well (Sweep::done_by).
    std::filesystem::path done() const { return folder / "done.json"; }
};

/// A command with every combination of some parameters. docs/sweeps.md has the file's format.
struct Sweep {
    std::vector<std::string> names;    ///< of the parameters, without dashes
    std::vector<SweepRun> runs;        ///< the last parameter changes fastest
    std::vector<std::string> compare;  ///< arguments of `pierce compare`; it runs if `compares`
    bool compares = false;
    std::filesystem::path out;

    /// What is written of a run that has ended well: its arguments, and those of the comparison.
    nlohmann::json done_by(const SweepRun& run, bool compared) const;
    /// True if the run's command has ended well with the arguments that it has now.
    bool has_run(const SweepRun& run) const;
    /// True if methods have been compared on the run's motion, whatever the arguments were.
    bool has_compared(const SweepRun& run) const;
    /// True if all results of a run are there.
    bool is_done(const SweepRun& run) const;
};

/// Throws InputError, naming the file and what is wrong in it, for anything but a sound sweep.
Sweep read_sweep(const std::filesystem::path& file);

}  // namespace pierce::app
