#pragma once

#include "app/output/page.hpp"
#include "app/reports/accuracy/accuracy_report.hpp"

namespace pierce::app {

/// What triangle tests lose, over the offset from the origin.
void leaks_figure(const AccuracyReportOptions& options, Page& page);

/// Which overlaps are missed, over the ratio of the two meshes' edge lengths.
void resolution_figure(const AccuracyReportOptions& options, Page& page);

/// How deep contacts of two equal spheres are, over how deep the spheres overlap.
void depth_figure(const AccuracyReportOptions& options, Page& page);

}  // namespace pierce::app
