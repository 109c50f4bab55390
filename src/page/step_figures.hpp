#pragma once

#include <nlohmann/json_fwd.hpp>

#include "pierce/plan.hpp"
#include "pierce/step_stats.hpp"

namespace pierce::page {

/// What a page's charts show of a step: `ms` by stage, depths and counts.
nlohmann::json step_figures(const StepStats& stats);

/// What a page says of a plan: how many bodies of each kind there are, and the stages that run.
nlohmann::json plan_figures(const Plan& plan);

}  // namespace pierce::page
