#pragma once

#include "app/cloth_report.hpp"
#include "app/page.hpp"

namespace pierce::app {

/// What each method misses and invents, and its time, on motions that cross themselves.
void cloth_accuracy_figure(const ClothReportOptions& options, Page& page);

/// How deep cloth on a capsule goes through itself over time, when each method's contacts keep it
/// apart (the paper's figure 16).
void cloth_penetration_figure(const ClothReportOptions& options, Page& page);

}  // namespace pierce::app
