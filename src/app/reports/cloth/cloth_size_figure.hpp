#pragma once

#include "app/output/page.hpp"
#include "app/reports/cloth/cloth_report.hpp"

namespace pierce::app {

/// Time beside error as sheets get finer: cloth on the capsule with ever more vertices, and the
/// layers. Also size.json.
void cloth_size_figure(const ClothReportOptions& options, Page& page);

}  // namespace pierce::app
