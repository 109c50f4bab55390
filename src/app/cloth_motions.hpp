#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "motion.hpp"
#include "pierce/scenes/recording.hpp"

namespace pierce::app {

struct ClothReportOptions;

/// A recorded motion of sheets that pass through themselves or each other, as nothing keeps them apart.
struct ClothMotion {
    std::string name;
    std::string what;  ///< in words
    scenes::Recording recording;
};

/// One for each scene of cloth: simulated without self-contact, so that there is something to find; every deforming body is
/// a sheet that is looked for in itself.
std::vector<ClothMotion> crossing_motions(const ClothReportOptions& options);

}  // namespace pierce::app
