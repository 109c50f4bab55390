#pragma once

#include "app/output/page.hpp"
#include "app/reports/cloth/cloth_report.hpp"

namespace pierce::app {

/// What each method misses and invents, and its time, on motions that cross themselves.
void cloth_accuracy_figure(const ClothReportOptions& options, Page& page);

/// How deep cloth on a capsule goes through itself over time, when each method's contacts keep it
/// apart (the paper's figure 16).
void cloth_penetration_figure(const ClothReportOptions& options, Page& page);

/// The deepest of the paper's figure 16, of sheets with vertices 0.4 apart [length].
inline constexpr double paper_penetration = 5.8651e-4;

/// The same depth for other readings of the paper's Algorithm 1 and its scene, over the time step
/// and over the resolution.
void cloth_variants_figure(const ClothReportOptions& options, Page& page);

}  // namespace pierce::app
