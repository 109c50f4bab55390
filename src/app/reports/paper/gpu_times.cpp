#include <algorithm>

#include "app/output/progress.hpp"
#include "app/output/statistics.hpp"
#include "app/reports/paper/gpu_results.hpp"
#include "app/reports/paper/modes.hpp"
#include "app/reports/paper/sections.hpp"
#include "scenes/recording/lattice.hpp"

namespace pierce::app {
namespace {

using scenes::LatticeMotion;

struct GpuScene {
    std::string name;
    const scenes::Recording* recording;
    bool compares = false;  ///< contacts with those of the first mode
};

std::vector<Mode> gpu_modes() {
    std::vector<Mode> modes;
    modes.push_back(mode("off", Temporal::off, false));
    modes.push_back(mode("paper", Temporal::paper, false));
    modes.push_back(mode("paper, predicting", Temporal::paper, true));
    modes.push_back(mode("certified", Temporal::certified, false));
    for (Mode& m : modes) m.backend = "cuda";
    return modes;
}

const std::vector<std::string> columns{
    "bodies",       "half",          "off_ms",       "paper_ms",       "predict_ms",
    "certified_ms", "off_rays",      "paper_rays",   "paper_walks",    "paper_lost",
    "predict_rays", "predict_walks", "off_contacts", "paper_contacts", "predict_contacts"};

/// One row for each half of the motion: mean times of a step, and what a step of each mode does.
void add_rows(Table& table, const GpuScene& scene) {
    std::vector<Mode> modes = gpu_modes();
    measure(*scene.recording, modes, "GPU, " + scene.name, scene.compares);
    for (const bool second : {false, true}) {
        std::vector<double> row{static_cast<double>(scene.recording->bodies.size()),
                                second ? 2.0 : 1.0};
        for (const Mode& m : modes) row.push_back(mean(m.half(second).ms));
        const auto a_step = [&](int m, std::uint64_t HalfOfMotion::*count) {
            const HalfOfMotion& half = modes[static_cast<std::size_t>(m)].half(second);
            return static_cast<double>(half.*count) /
                   static_cast<double>(std::max<std::size_t>(half.ms.size(), 1));
        };
        row.push_back(a_step(0, &HalfOfMotion::rays));
        row.push_back(a_step(1, &HalfOfMotion::rays));
        row.push_back(a_step(1, &HalfOfMotion::walks));
        row.push_back(a_step(1, &HalfOfMotion::lost));
        row.push_back(a_step(2, &HalfOfMotion::rays));
        row.push_back(a_step(2, &HalfOfMotion::walks));
        for (int m = 0; m < 3; ++m) row.push_back(a_step(m, &HalfOfMotion::contacts));
        table.labels.push_back(scene.name);
        table.rows.push_back(std::move(row));
    }
}

Table measure_all(std::span<const Pile> piles, const PaperReportOptions& options) {
    Table table{.names = columns, .rows = {}, .labels = {}};
    for (const Pile& pile : piles) add_rows(table, {pile.name, &pile.loop.recording, true});
    for (const std::uint32_t count : options.lattices)
        for (const auto& [name, motion] : {std::pair{"rigid lattice", LatticeMotion::rigid},
                                           std::pair{"resting lattice", LatticeMotion::rest},
                                           std::pair{"soft lattice", LatticeMotion::soft}}) {
            const std::uint32_t frames = motion == LatticeMotion::soft && count > 2000 ? 24 : 80;
            const scenes::Recording recording = scenes::lattice(count, frames, motion);
            add_rows(table, {name, &recording, false});
        }
    return table;
}

}  // namespace

void tables_2_and_3_on_gpu(const PaperReportOptions& options, std::span<const Pile> piles,
                           Page& page) {
    page.line("\n### On a GPU\n");
    page.line(
        "Whole steps, each one launch of a captured graph, as the device's clock has them; means "
        "over each half of the motion, which hold full passes and the steps between them. Contacts "
        "are a step's. *Certified* runs as *off* on a GPU.");
    const auto table = on_gpu(options, page, "tables_2_3_gpu",
                              [&] { return measure_all(piles, options); });
    if (!table) return;
    page.line(
        "\n| scene, bodies, half | off [ms] | paper [ms] | + prediction [ms] | certified [ms] | "
        "off / paper | prediction costs | rays: off | paper: rays, walks, lost | + prediction: "
        "rays, walks | contacts: off, paper, + prediction |\n|---|---|---|---|---|---|---|---|---|"
        "---|---|");
    for (std::size_t i = 0; i < table->rows.size(); ++i) {
        const std::vector<double>& r = table->rows[i];
        page.line(
            "| {}, {:g}, {} | {:.4f} | {:.4f} | {:.4f} | {:.4f} | {:.2f} | {:+.1f} % | {:.0f} | "
            "{:.0f}, {:.0f}, {:.0f} | {:.0f}, {:.0f} | {:.0f}, {:.0f}, {:.0f} |",
            table->labels[i], r[0], r[1] == 1 ? "first" : "second", r[2], r[3], r[4], r[5],
            r[2] / r[3], 100 * (r[4] / r[3] - 1), r[6], r[7], r[8], r[9], r[10], r[11], r[12],
            r[13], r[14]);
    }
}

}  // namespace pierce::app
