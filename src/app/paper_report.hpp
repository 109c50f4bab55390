#pragma once

#include <cstdint>
#include <filesystem>

namespace pierce::app {

struct PaperReportOptions {
    std::filesystem::path out;
    std::uint32_t count = 100;
    double seconds = 12;
    double dt = 1.0 / 60;
    std::uint32_t seed = 1;
};

/// Runs the paper's experiments and writes one page, report.md, with our figures beside the paper's, and for each experiment
/// a CSV file and, if gnuplot is installed, an SVG picture. Returns the exit code; throws InputError if the folder cannot be
/// written.
int report_paper(const PaperReportOptions& options);

}  // namespace pierce::app
