#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenes/contact_error.hpp"
#include "scenes/detector.hpp"
#include "scenes/recording.hpp"

namespace pierce::app {

/// A way of tracing rays, and what came of it on a recording.
struct Mode {
    std::string name;
    Settings settings;
    std::unique_ptr<scenes::Detector> detector;
    scenes::ContactComparison comparison;
    std::vector<double> moving_ms;  ///< narrow phase in the first half of the recording
    std::vector<double> narrow_ms;  ///< and in the second one
    std::uint64_t moving_contacts = 0;
    std::uint64_t rays = 0, walks = 0, walk_steps = 0, lost = 0, contacts = 0;  ///< in the second
                                                                                ///< half

    double median_ms() const;
    double moving_median_ms() const;
};

Mode mode(std::string name, Temporal temporal, bool predict);

/// All modes on the same frames, taking turns frame by frame on one thread; counts are of its
/// second half, errors of all of it. The first mode is the truth of the others.
void measure(const scenes::Recording& recording, std::vector<Mode>& modes, const std::string& what);

}  // namespace pierce::app
