#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "scenes/recording/recording.hpp"

namespace pierce::scenes {

/// Parameters of a crossing motion.
struct CrossingMotionParameters {
    double seconds = 4;
    double dt = 1.0 / 60;     ///< [s]
    std::uint32_t nodes = 0;  ///< of a sheet, along a side; 0: as many as the scene was made for
    std::uint32_t seed = 1;
};

/// The scenes of cloth by name: cloth-capsule, cloth-fold, cloth-twist, ball-squash and layers.
std::span<const std::string> crossing_motion_names();

/// A scene of cloth simulated without self-contact, so that there is something to find; in layers,
/// every other sheet sinks through its neighbour and comes back. Every deforming body of the
/// recording is a sheet whose contacts with itself are looked for. Throws InputError for an unknown
/// name or a time that is not positive.
Recording crossing_motion(const std::string& name, const CrossingMotionParameters& parameters = {});

}  // namespace pierce::scenes
