#include <algorithm>

#include "app/measure/in_parallel.hpp"
#include "app/measure/motion.hpp"
#include "app/output/statistics.hpp"
#include "app/reports/paper/curves.hpp"
#include "app/reports/paper/modes.hpp"
#include "app/reports/paper/sections.hpp"

namespace pierce::app {

void figure_9(const Pile& pile, const PaperReportOptions& options, Page& page) {
    constexpr const char* names[] = {"paper's rays", "with prediction", "all rays (off)"};
    const Settings settings[] = {mode("", Temporal::paper, false).settings,
                                 mode("", Temporal::paper, true).settings,
                                 mode("", Temporal::off, false).settings};
    Timing timing = options.timing;
    if (pile.soft) timing.seconds = std::min(timing.seconds, options.soft_seconds);
    std::vector<double> time, depths[3];
    double deepest[3] = {};
    std::vector<TimeColumn> columns;
    for (std::uint32_t i = 0; i < timing.steps(); ++i) time.push_back(i * timing.dt);
    in_parallel("making figure 9", 3, [&](std::size_t k) {
        // Steps that remember nothing have the contacts of certified ones, and so their motion.
        const bool known = settings[k].temporal == Temporal::off;
        ClosedLoop made;
        if (!known) made = simulate(pile.scene, scenes::Method::rays, settings[k], timing, 1);
        const FrameLog all = watch(pile.scene, known ? pile.loop.recording : made.recording,
                                   scenes::Method::rays, settings[2], 1);
        depths[k] = all.column(&scenes::FrameResult::penetration_mean);
        deepest[k] = std::ranges::max(all.column(&scenes::FrameResult::penetration_max));
    });
    columns.reserve(3);
    for (int k = 0; k < 3; ++k) columns.push_back({names[k], depths[k]});
    page.line("\n### {}\n", pile.name);
    page.line(
        "{} bodies, the loop closed, a full pass every {} steps. Each run has a motion of its own; "
        "depths are those of all its contacts.\n",
        pile.scene.bodies.size() - 1, settings[0].full_every);
    page.line("| | mean depth over the run | deepest |\n|---|---|---|");
    constexpr const char* lines[] = {"iterative rays", "iterative and predictive rays",
                                     "all rays, every step"};
    for (int k = 0; k < 3; ++k)
        page.line("| {} | {:.5f} | {:.4f} |", lines[k], mean(depths[k]), deepest[k]);
    const Table curves = over_time(time, columns, depth_window);
    const auto deeper = std::ranges::count_if(
        curves.rows, [](const std::vector<double>& row) { return row[2] > row[1]; });
    page.line("\nDeeper with prediction than without in {} of {} stretches of {:g} s.", deeper,
              curves.rows.size(), depth_window);
    page.plot(Curves{.title = fmt::format("Penetration over time, {}, loop closed", pile.title()),
                     .x = "time [s]",
                     .y = {"mean depth of all contacts [length]"},
                     .table = curves,
                     .lines = {{.look = "walk"}, {.look = "walk-predict"}, {.look = "full"}}},
              "figure_9_" + pile.name);
}

}  // namespace pierce::app
