#pragma once

#include "app/cloth_report.hpp"
#include "app/page.hpp"

namespace pierce::app {

/// Time beside error as sheets get finer: cloth on the capsule with ever more vertices, and the
/// layers. Also size.json.
void cloth_size_figure(const ClothReportOptions& options, Page& page);

}  // namespace pierce::app
