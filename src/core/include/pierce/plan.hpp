#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "pierce/settings.hpp"
#include "pierce/stage.hpp"

namespace pierce {

/// What one of the backends that share a world does.
struct PlannedPart {
    std::string backend;          ///< Backend::description()
    bool on_device = false;       ///< it runs on a GPU
    double share = 1;             ///< of the work, as its maker has asked for
    std::uint32_t bodies = 0;     ///< that it owned in the last step; 0 before the first one
    std::uint32_t ghosts = 0;     ///< bodies of other parts that were near in the last step
    std::uint64_t triangles = 0;  ///< of both

    friend bool operator==(const PlannedPart&, const PlannedPart&) = default;
};

/// What a world's bodies require of a step, decided when bodies are added, removed or change kind.
struct Plan {
    std::uint64_t revision = 0;  ///< changes with every new plan
    std::uint32_t fixed_bodies = 0, rigid_bodies = 0, deforming_bodies = 0;
    std::uint32_t open_bodies = 0;      ///< bodies without an inside: sources only
    std::uint32_t worlds = 0;           ///< different ones in Filter::world, without all_worlds
    std::uint32_t excluded_pairs = 0;   ///< by World::exclude()
    bool measures_deformation = false;  ///< bounds measures vertices, and trees are refitted
    bool casts_rays = false;  ///< some body has an inside in which others are looked for, or is
                              ///< looked for in itself by rays along velocities
    bool traces_own_exits = false;   ///< contacts need a second ray, into their own body
    bool meets_itself = false;       ///< some solid is looked for in itself
    bool sheets = false;             ///< some body is a sheet
    std::uint32_t feature_bits = 0;  ///< bits of the largest number of a vertex, edge or triangle
    bool velocity_rays = false;   ///< some sheet is looked for in itself by rays along velocities
    bool margins = false;         ///< some body is in contact before it touches
    bool reprojects = false;      ///< contacts move to the closest point of the target's surface
    Settings settings;            ///< the settings in effect: what no body needs is off
    std::vector<StageId> stages;  ///< the stages that run, in their order
    std::vector<std::string> notes;  ///< rules that do not apply to some body, and why
    std::vector<PlannedPart> parts;  ///< what runs where; empty if one backend does all

    bool remembers() const { return settings.temporal != Temporal::off; }
    bool is_complete() const { return settings.coverage == Coverage::complete; }
    /// True if pairs that overlap without a vertex inside are found, too.
    bool misses_no_overlap() const { return settings.coverage != Coverage::vertices; }
    /// True if boxes around the triangles of deforming solids are measured.
    bool needs_boxes() const { return misses_no_overlap() || margins; }
    bool needs(StageId stage) const { return std::ranges::find(stages, stage) != stages.end(); }
    /// True if steps of both plans do the same; what is told of the bodies may differ.
    bool steps_like(const Plan& other) const {
        Plan same = other;
        same.revision = revision;
        same.open_bodies = open_bodies;
        same.notes = notes;
        same.parts = parts;
        return same == *this;
    }

    friend bool operator==(const Plan&, const Plan&) = default;
};

}  // namespace pierce
