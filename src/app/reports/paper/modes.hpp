#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "scenes/detect/detector.hpp"
#include "scenes/measure/contact_error.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::app {

/// What a way of tracing rays did in part of a motion.
struct PartOfMotion {
    /// [ms] narrow phase of every step; of steps that a GPU repeats, the whole step.
    std::vector<double> ms;
    std::uint32_t not_captured = 0;  ///< steps of a GPU that were not repeated, which `ms` leaves
                                     ///< out
    std::uint64_t rays = 0, walks = 0, walk_steps = 0, lost = 0, contacts = 0;

    double median_ms() const;
};

/// A way of tracing rays, and what came of it on a recording.
struct Mode {
    std::string name;
    Settings settings;
    std::string backend = "embree";  ///< with one thread
    std::unique_ptr<scenes::Detector> detector = nullptr;
    scenes::ContactComparison comparison = {};
    std::array<PartOfMotion, 2> halves = {};

    const PartOfMotion& half(bool second) const { return halves[second ? 1 : 0]; }
    PartOfMotion whole() const;
};

Mode mode(std::string name, Temporal temporal, bool predict);

/// All modes on the same frames, taking turns frame by frame. The first mode is the truth of the
/// others; contacts are compared unless `compares` is false.
void measure(const scenes::Recording& recording, std::vector<Mode>& modes, const std::string& what,
             bool compares = true);

}  // namespace pierce::app
