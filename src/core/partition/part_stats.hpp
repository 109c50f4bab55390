#pragma once

#include <cstdint>
#include <span>

#include "pierce/step_stats.hpp"

namespace pierce {

/// Adds what parts that ran at the same time did and found: counts are added up, a time is that of
/// the slowest part.
void add_parts(std::span<const StepStats> parts, StepStats& whole);

/// The counts of a step that are added up.
std::span<std::uint32_t StepStats::*const> added_counts();

}  // namespace pierce
