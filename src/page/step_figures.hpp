#pragma once

#include <nlohmann/json_fwd.hpp>

#include "pierce/step_stats.hpp"

namespace pierce::page {

/// What a page's charts show of a step: `ms` by stage, depths and counts.
nlohmann::json step_figures(const StepStats& stats);

}  // namespace pierce::page
