#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pierce/scenes/contact_error.hpp"
#include "pierce/scenes/detector.hpp"
#include "pierce/scenes/recording.hpp"

namespace pierce::app {

/// A way of tracing rays, and what came of it on a recording.
struct Mode {
    std::string name;
    Settings settings;
    std::unique_ptr<scenes::Detector> detector;
    scenes::ContactComparison comparison;
    std::vector<double> narrow_ms;  ///< of the frames that count
    std::uint64_t rays = 0, walks = 0, walk_steps = 0, lost = 0, contacts = 0;

    double median_ms() const;
};

Mode mode(std::string name, Temporal temporal, bool predict);

/// All modes on the same frames, taking turns frame by frame on one thread; times count from the middle of the recording,
/// errors from its beginning. The first mode is the truth of the others.
void measure(const scenes::Recording& recording, std::vector<Mode>& modes, const std::string& what);

}  // namespace pierce::app
