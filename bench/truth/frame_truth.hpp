#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "scenes/named/pair_rules.hpp"
#include "scenes/recording/recording.hpp"
#include "truth/exact_mesh.hpp"

namespace pierce::truth {

/// A vertex of one body strictly inside another.
struct InsideVertex {
    std::uint32_t source = 0, target = 0, vertex = 0;
    double depth = 0;  ///< [length] to the target's surface
    Vec3d normal;      ///< unit, in world space, towards the closest point of the target's surface
};

/// What every method should find in a frame. Bodies by their index in the recording.
struct FrameTruth {
    std::uint32_t frame = 0;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> overlapping;  ///< sorted, lower body first
    std::vector<InsideVertex> inside;  ///< by source, target, vertex
};

/// The truth about a recording. Two fixed bodies are no pair; nothing is inside an open body, whose
/// pairs overlap only if the surfaces intersect; a body that is not finite in a frame is left out
/// of it.
class RecordingTruth {
public:
    /// The recording must stay.
    explicit RecordingTruth(const scenes::Recording& recording);

    /// `frame` must be one of the recording's. Without `vertices`, only pairs are looked at.
    FrameTruth at(std::uint32_t frame, bool vertices = true) const;

private:
    const scenes::Recording& recording_;
    scenes::PairRules rules_;
    std::vector<std::vector<Triangle>> triangles_;  ///< per mesh, those of its surface
    std::vector<ExactMesh> rest_;                   ///< per mesh
};

}  // namespace pierce::truth
