#include "app/reports/paper/paper_report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/measure/truth_program.hpp"
#include "app/reports/cloth/cloth_figures.hpp"
#include "app/reports/paper/sections.hpp"

namespace pierce::app {
namespace {

Timing timing_of(const PaperReportOptions& options, bool soft) {
    Timing timing = options.timing;
    if (soft) timing.seconds = std::min(timing.seconds, options.soft_seconds);
    return timing;
}

Pile make_pile(const PaperReportOptions& options, const char* scene, std::uint32_t count,
               bool soft) {
    Pile pile{.name = std::string(scene) + (soft ? "_soft" : ""),
              .soft = soft,
              .scene = scenes::make_scene(scene, {count, soft, options.seed}),
              .loop = {}};
    pile.loop = simulate(pile.scene, scenes::Method::rays, vertex_rays, timing_of(options, soft),
                         1);
    return pile;
}

nlohmann::json settings_of(const PaperReportOptions& options) {
    return {
        {"bodies", options.count},           {"bunnies of figures 10 and 11", options.bunnies},
        {"seconds", options.timing.seconds}, {"seconds of soft piles", options.soft_seconds},
        {"dt", options.timing.dt},           {"seed", options.seed},
        {"runs of figure 14", options.runs}, {"truth for every Nth frame", options.truth_every}};
}

}  // namespace

void PaperReportOptions::make_quick() {
    count = 16;
    bunnies = 8;
    timing.seconds = 4;
    soft_seconds = 2;
    runs = 1;
    landing_seconds = 5;
    cloth_seconds = 2;
    lattices = {100};
}

namespace {

void write_curves(std::span<const Pile> rigid, Page& page) {
    page.line("\n## What threshold and period cost\n");
    for (const Pile& pile : rigid) {
        threshold_map(pile, page);
        period_map(pile, page);
    }
}

void write_quality(std::span<const Pile> piles, const PaperReportOptions& options, Page& page) {
    std::vector<Quality> qualities;
    for (const Pile& pile : piles) {
        const bool fewer = pile.scene.name == "bunnies" && options.bunnies != options.count;
        const Pile small = fewer ? make_pile(options, "bunnies", options.bunnies, pile.soft)
                                 : Pile{};
        const Pile& shown = fewer ? small : pile;
        qualities.push_back(measure_quality(shown.scene, shown.soft, shown.loop,
                                            timing_of(options, pile.soft), options.truth_every));
    }
    table_4(qualities, page);
    for (const int bunnies : {1, 0})
        for (const Quality& q : qualities) {
            if ((q.file.starts_with("bunnies")) != (bunnies == 1)) continue;
            colliding_pairs(q, bunnies == 1 ? 10 : 12, page);
            average_depth(q, bunnies == 1 ? 11 : 13, page);
        }
}

void write_cloth(const PaperReportOptions& options, Page& page) {
    figure_15(options, page);
    ClothReportOptions cloth;
    cloth.out = options.out;
    cloth.falling.seconds = options.cloth_seconds;
    cloth.seed = options.seed;
    cloth_penetration_figure(cloth, page);
    cloth_variants_figure(cloth, page);
}

}  // namespace

int report_paper(const PaperReportOptions& options) {
    const auto has = [&](const char* part) {
        return std::ranges::find(options.parts, part) != options.parts.end();
    };
    if (has("quality") || has("cloth")) check_truth_program();
    Page page(options.out, "The paper's experiments, measured here", settings_of(options),
              options.html);
    std::vector<Pile> piles;  // tori, bunnies; soft tori, soft bunnies
    const auto rigid = [&] { return std::span(piles).first(2); };
    const auto make_piles = [&] {
        for (const bool soft : {false, true})
            for (const char* scene : {"tori", "bunnies"})
                piles.push_back(make_pile(options, scene, options.count, soft));
    };
    const auto prediction = [&] {
        page.line("\n## Figure 9: penetration with and without prediction\n");
        for (const Pile& pile : piles) figure_9(pile, options, page);
    };
    const auto time_step = [&] {
        page.line("\n## Figure 14: penetration against the time step\n");
        for (const Pile& pile : piles) figure_14(pile, options, page);
    };
    std::vector<Page::Part> parts{
        {"pictures", [&] { pictures_of_piles(piles[0], piles[1], page); }},
        {"trees", [&] { table_1(options, piles[2], page); }},
        {"times", [&] { tables_2_and_3(piles, page); }},
        {"gpu", [&] { tables_2_and_3_on_gpu(options, piles, page); }},
        {"curves", [&] { write_curves(rigid(), page); }},
        {"prediction", prediction},
        {"quality", [&] { write_quality(piles, options, page); }},
        {"time-step", time_step},
        {"cloth", [&] { write_cloth(options, page); }},
        {"crossover", [&] { crossover(options, page); }}};
    std::erase_if(parts, [&](const Page::Part& part) { return !has(part.name.c_str()); });
    parts.insert(parts.begin(), {"motions of the piles", make_piles});
    page.write(parts);
    return 0;
}

}  // namespace pierce::app
