#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/measure/motion.hpp"

namespace pierce::app {

struct ClothReportOptions {
    std::filesystem::path out;
    std::filesystem::path html;    ///< the one file; empty: report.html in that folder
    Timing timing{4, 1.0 / 60};    ///< of the motions that methods are compared on
    Timing falling{12, 1.0 / 60};  ///< of the cloth on the capsule, figure 16
    std::uint32_t nodes = 0;  ///< of a sheet, along a side; 0: as many as the scene was made for
    std::uint32_t seed = 1;
    int threads = 1;  ///< for detection
    std::vector<std::string> parts{"accuracy", "penetration", "size"};
    std::vector<std::uint32_t> sizes{20, 100, 300};  ///< of the part size: vertices along a side of
                                                     ///< the sheet
    double size_seconds = 1.5;                       ///< simulated time of its sheets
    std::uint32_t layers_nodes = 0;                  ///< of its layers, as in `nodes`
};

/// Measures which meetings of sheets each method misses or invents, and how long it takes, against
/// exact truth, and how deep cloth that is simulated with its contacts goes through itself, and
/// both as sheets get finer. Writes one page, report.md, and for each figure a CSV file and, if
/// matplotlib is installed, an SVG picture. Returns the exit code; throws InputError if the folder
/// cannot be written or pierce_truth is missing.
int report_cloth(const ClothReportOptions& options);

}  // namespace pierce::app
