#pragma once

#include <functional>
#include <optional>
#include <string>

#include "app/output/page.hpp"
#include "app/reports/paper/paper_report.hpp"

namespace pierce::app {

/// Writes what is measured so far, so that a run that is cut off leaves it.
using KeepTable = std::function<void(const Table&)>;

/// A table that needs a GPU: measured, and written as NAME.csv, where CUDA can run; else taken from
/// the folder of results that the options name, as it is there. If there is neither, the page says
/// so, and the result is empty.
std::optional<Table> on_gpu(const PaperReportOptions& options, Page& page, const std::string& name,
                            const std::function<Table(const KeepTable&)>& measure);

}  // namespace pierce::app
