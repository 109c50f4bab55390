#include <algorithm>

#include "app/motion.hpp"
#include "app/paper_curves.hpp"
#include "app/paper_modes.hpp"
#include "app/paper_sections.hpp"
#include "app/statistics.hpp"

namespace pierce::app {

void figure_9(const PaperReportOptions& options, Page& page) {
    const scenes::SceneSetup scene = scenes::make_scene("tori",
                                                        {options.count, false, options.seed});
    constexpr const char* names[] = {"paper's rays", "with prediction", "all rays (off)"};
    const Settings settings[] = {mode("", Temporal::paper, false).settings,
                                 mode("", Temporal::paper, true).settings,
                                 mode("", Temporal::off, false).settings};
    std::vector<double> time, depths[3];
    double deepest[3] = {};
    std::vector<TimeColumn> columns;
    for (std::uint32_t i = 0; i < options.timing.steps(); ++i)
        time.push_back(i * options.timing.dt);
    for (int k = 0; k < 3; ++k) {
        const ClosedLoop loop = simulate(scene, scenes::Method::rays, settings[k], options.timing);
        const FrameLog all = watch(scene, loop.recording, scenes::Method::rays, settings[2]);
        depths[k] = all.column(&scenes::FrameResult::penetration_mean);
        deepest[k] = std::ranges::max(all.column(&scenes::FrameResult::penetration_max));
        columns.push_back({names[k], depths[k]});
    }
    page.line("## Figure 9: penetration with and without prediction\n");
    page.line(
        "{} tori, the loop closed, a full pass every {} steps. Each run has a motion of its own; "
        "depths are those of all "
        "its contacts.\n",
        options.count, settings[0].full_every);
    page.line("| | mean depth over the run | deepest |\n|---|---|---|");
    constexpr const char* lines[] = {"iterative rays", "iterative and predictive rays",
                                     "all rays, every step"};
    for (int k = 0; k < 3; ++k)
        page.line("| {} | {:.5f} | {:.4f} |", lines[k], mean(depths[k]), deepest[k]);
    page.plot(Curves{.title = "Penetration over time, tori, loop closed",
                     .x = "time [s]",
                     .y = "mean depth of all contacts",
                     .table = over_time(time, columns, depth_window)},
              "figure_9");
}

}  // namespace pierce::app
