#include "cloth_report.hpp"

#include "cloth_figures.hpp"
#include "frame_log.hpp"
#include "page.hpp"
#include "truth_program.hpp"

namespace pierce::app {

int report_cloth(const ClothReportOptions& options) {
    check_truth_program();
    Page page(options.out);
    page.line("# Cloth: time and error, measured here\n");
    page.line("{}\n{}\n", machine_json().dump(), versions_json().dump());
    page.line("Seed {}. Threads for detection: {}.\n", options.seed, options.threads);
    cloth_accuracy_figure(options, page);
    cloth_penetration_figure(options, page);
    page.close();
    return 0;
}

}  // namespace pierce::app
