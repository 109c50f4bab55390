#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/measure/motion.hpp"

namespace pierce::app {

struct PaperReportOptions {
    std::filesystem::path out;
    std::filesystem::path html;         ///< the one file; empty: report.html in that folder
    std::filesystem::path gpu_results;  ///< folder from which parts that need a GPU are merged, if
                                        ///< there is none here; empty: they are left out
    std::uint32_t count = 100;          ///< falling bodies
    std::uint32_t bunnies = 30;         ///< falling bodies of figures 10 and 11
    Timing timing{.seconds = 20};       ///< long enough for both piles to come to rest
    double soft_seconds = 8;            ///< of soft piles, which take ten times as long to simulate
    std::uint32_t seed = 1;
    double landing_seconds = 10;    ///< simulated time of figure 14; the paper looks at the last 7
    std::uint32_t runs = 3;         ///< of figure 14, with a seed each; soft bodies have one
    std::uint32_t truth_every = 4;  ///< figures 10 to 13 show every Nth frame
    double cloth_seconds = 6;       ///< simulated time of figures 15 and 16
    std::vector<std::uint32_t> lattices{100, 1000, 10000};  ///< bodies of scenes on the GPU alone
    std::vector<std::string> parts = all_parts();

    static std::vector<std::string> all_parts() {
        return {"pictures", "trees",     "times", "curves", "prediction",
                "quality",  "time-step", "cloth", "gpu",    "crossover"};
    }
    /// Few bodies, short motions: all sections in about two minutes.
    void make_quick();
};

/// Runs the paper's experiments and writes one page, report.md and report.html, with our figures
/// beside the paper's, and for each experiment a CSV file and, if matplotlib is installed, an SVG
/// picture. Returns the exit code; throws InputError if the folder cannot be written, and as
/// check_truth_program() does.
int report_paper(const PaperReportOptions& options);

}  // namespace pierce::app
