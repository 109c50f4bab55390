#include "app/paper_report.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "app/paper_sections.hpp"
#include "app/truth_program.hpp"

namespace pierce::app {

int report_paper(const PaperReportOptions& options) {
    check_truth_program();
    Page page(options.out);
    const auto& [seconds, dt] = options.timing;
    page.line("# The paper's experiments, measured here\n");
    page.line("{}\n{} bodies, {:g} s at {:g} s a step, seed {}.\n", machine_json().dump(),
              options.count, seconds, dt, options.seed);

    const auto wanted = [&](const char* part) {
        return std::ranges::find(options.parts, part) != options.parts.end();
    };
    std::vector<NamedRecording> recordings;
    for (bool soft : {false, true})
        for (const char* name : {"tori", "bunnies"}) {
            if (!wanted("times") && (soft || !wanted("curves"))) continue;
            const scenes::SceneSetup scene = scenes::make_scene(
                name, {options.count, soft, options.seed});
            recordings.emplace_back(
                std::string(name) + (soft ? "_soft" : ""),
                simulate(scene, scenes::Method::rays, {}, options.timing).recording);
        }
    if (wanted("times")) tables_2_and_3(recordings, page);
    if (wanted("curves")) {
        page.line("## What threshold and period cost\n");
        for (const NamedRecording& rigid : std::span(recordings).first(2)) {
            threshold_map(rigid, page);
            period_map(rigid, page);
        }
    }
    if (wanted("prediction")) figure_9(options, page);

    const auto figures_of = [&](const char* name, std::uint32_t count, int pairs_figure,
                                int depth_figure) {
        const Quality quality = measure_quality(
            scenes::make_scene(name, {count, false, options.seed}), options.timing,
            options.truth_every);
        colliding_pairs(quality, pairs_figure, page);
        average_depth(quality, depth_figure, page);
    };
    if (wanted("quality")) {
        figures_of("bunnies", options.bunnies, 10, 11);
        figures_of("tori", options.count, 12, 13);
    }
    if (wanted("time-step")) figure_14(options, page);
    page.close();
    return 0;
}

}  // namespace pierce::app
