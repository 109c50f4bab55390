#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/motion.hpp"

namespace pierce::app {

struct PaperReportOptions {
    std::filesystem::path out;
    std::uint32_t count = 100;     ///< falling bodies
    std::uint32_t bunnies = 30;    ///< falling bodies of figures 10 and 11
    Timing timing{.seconds = 20};  ///< long enough for both piles to come to rest
    std::uint32_t seed = 1;
    std::uint32_t runs = 5;         ///< of figure 14, with a seed each
    std::uint32_t truth_every = 1;  ///< figures 10 to 13 show every Nth frame
    std::vector<std::string> parts{"times", "curves", "prediction", "quality", "time-step"};
};

/// Runs the paper's experiments and writes one page, report.md, with our figures beside the
/// paper's, and for each experiment a CSV file and, if gnuplot is installed, an SVG picture.
/// Returns the exit code; throws InputError if the folder cannot be written, and as
/// check_truth_program() does.
int report_paper(const PaperReportOptions& options);

}  // namespace pierce::app
