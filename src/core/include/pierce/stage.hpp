#pragma once

#include <cstdint>
#include <span>

namespace pierce {

struct Plan;

/// The stages of a step, in the order in which docs/step.md describes them.
enum class StageId : std::uint8_t {
    bounds,
    pairs,
    sheets,
    displacement,
    vertex_cull,
    ray_gen,
    edges,
    walk,
    update,
    trace,
    classify,
    self_overlap,
    reproject,
    separation,
    margin,
    contacts,
    remember,
    statistics
};

/// The description of a stage.
struct StageInfo {
    StageId id;
    const char* name;
    bool (*needed)(const Plan& plan);
    const char* when;    ///< the same in words
    const char* reads;   ///< of earlier stages, and of the last step
    const char* writes;  ///< for later stages, and for the next step
    const char* page;    ///< in docs
};

/// All stages in their order: the plan, the step, the step's times and docs/step.md follow this
/// table.
std::span<const StageInfo> stage_table();

const char* name_of(StageId stage);

}  // namespace pierce
