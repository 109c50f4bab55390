#pragma once

#include "app/output/page.hpp"
#include "app/reports/accuracy/accuracy_report.hpp"

namespace pierce::app {

/// Meshes of which a part of the triangles is gone or turned, against the exact truth of the whole
/// meshes: what the winding number finds, and what is found if a damaged mesh has no inside. Also
/// as damaged_meshes.csv.
void damaged_meshes(const AccuracyReportOptions& options, Page& page);

}  // namespace pierce::app
