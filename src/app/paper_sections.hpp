#pragma once

#include <span>
#include <string>
#include <utility>

#include "app/page.hpp"
#include "app/paper_quality.hpp"
#include "app/paper_report.hpp"
#include "scenes/recording.hpp"

/// The sections of the paper's report: each measures one thing and writes it down.
namespace pierce::app {

using NamedRecording = std::pair<std::string, scenes::Recording>;

/// What iterative rays save, and what prediction costs, in time and in contacts.
void tables_2_and_3(std::span<const NamedRecording> recordings, Page& page);

/// F4: what the walk threshold costs.
void threshold_map(const NamedRecording& named, Page& page);

/// F12: full passes every K steps against how far predictions look.
void period_map(const NamedRecording& named, Page& page);

/// The loop closed, with and without prediction. Depths are those of all contacts there are, traced
/// anew in every frame.
void figure_9(const PaperReportOptions& options, Page& page);

/// Figures 10 and 12: colliding pairs in each frame.
void colliding_pairs(const Quality& quality, int figure, Page& page);

/// Figures 11 and 13: average penetration depth over time.
void average_depth(const Quality& quality, int figure, Page& page);

/// Penetration against the time step.
void figure_14(const PaperReportOptions& options, Page& page);

}  // namespace pierce::app
