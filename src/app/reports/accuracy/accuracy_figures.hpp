#pragma once

#include "app/output/page.hpp"
#include "app/reports/accuracy/accuracy_report.hpp"

namespace pierce::app {

/// The compared method that has the default settings: it stands out in plots.
inline constexpr const char* default_method = "overlaps";

/// Of each method, time a frame against missed pairs and missed depth. `figures`: of
/// figures_of(), or read from the file of such a plot.
Scatter speed_against_error(const Table& figures, const std::string& title);

/// What triangle tests lose, over the offset from the origin.
void leaks_figure(const AccuracyReportOptions& options, Page& page);

/// Which overlaps are missed, over the ratio of the two meshes' edge lengths.
void resolution_figure(const AccuracyReportOptions& options, Page& page);

/// How deep contacts of two equal spheres are, over how deep the spheres overlap.
void depth_figure(const AccuracyReportOptions& options, Page& page);

}  // namespace pierce::app
