#include <algorithm>
#include <optional>

#include "app/output/progress.hpp"
#include "app/output/statistics.hpp"
#include "app/output/waiting.hpp"
#include "app/reports/paper/gpu_results.hpp"
#include "app/reports/paper/modes.hpp"
#include "app/reports/paper/sections.hpp"
#include "scenes/recording/lattice.hpp"

namespace pierce::app {
namespace {

using scenes::LatticeMotion;

/// Frames of a pile in each of its two phases.
constexpr std::uint32_t phase_frames = 120;

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
    "bodies",        "off_ms",       "paper_ms",       "predict_ms",      "certified_ms",
    "off_rays",      "paper_rays",   "paper_walks",    "paper_lost",      "predict_rays",
    "predict_walks", "off_contacts", "paper_contacts", "predict_contacts"};

/// Mean times of a step that the GPU repeats, and what a step of each mode does.
void add_row(Table& table, const std::string& name, const scenes::Recording& recording,
             const KeepTable& keep) {
    std::vector<Mode> modes = gpu_modes();
    measure(recording, modes, "GPU, " + name, false);
    std::vector<double> row{static_cast<double>(recording.bodies.size())};
    for (const Mode& m : modes) row.push_back(mean(m.whole().ms));
    const auto a_step = [&](std::size_t m, std::uint64_t PartOfMotion::*count) {
        return static_cast<double>(modes[m].whole().*count) / recording.frame_count;
    };
    row.push_back(a_step(0, &PartOfMotion::rays));
    row.push_back(a_step(1, &PartOfMotion::rays));
    row.push_back(a_step(1, &PartOfMotion::walks));
    row.push_back(a_step(1, &PartOfMotion::lost));
    row.push_back(a_step(2, &PartOfMotion::rays));
    row.push_back(a_step(2, &PartOfMotion::walks));
    for (std::size_t m = 0; m < 3; ++m) row.push_back(a_step(m, &PartOfMotion::contacts));
    table.labels.push_back(name);
    table.rows.push_back(std::move(row));
    keep(table);
}

Table measure_all(std::span<const Pile> piles, const PaperReportOptions& options,
                  const KeepTable& keep) {
    Table table{.names = columns, .rows = {}, .labels = {}};
    for (const std::uint32_t count : options.lattices)
        for (const auto& [name, motion] : {std::pair{"rigid lattice", LatticeMotion::rigid},
                                           std::pair{"resting lattice", LatticeMotion::rest},
                                           std::pair{"soft lattice", LatticeMotion::soft}}) {
            const std::uint32_t frames = motion == LatticeMotion::soft && count > 2000 ? 24 : 80;
            std::optional<Waiting> making(fmt::format("making {} tori, {}", count, name));
            const scenes::Recording recording = scenes::lattice(count, frames, motion);
            making.reset();
            add_row(table, name, recording, keep);
        }
    for (const Pile& pile : piles) {
        const scenes::Recording& all = pile.loop.recording;
        const std::uint32_t frames = std::min(phase_frames, all.frame_count / 2);
        add_row(table, pile.name + " at half time",
                scenes::excerpt(all, all.frame_count / 2 - frames, frames), keep);
        add_row(table, pile.name + " at the end",
                scenes::excerpt(all, all.frame_count - frames, frames), keep);
    }
    return table;
}

}  // namespace

void tables_2_and_3_on_gpu(const PaperReportOptions& options, std::span<const Pile> piles,
                           Page& page) {
    page.line("\n### On a GPU\n");
    page.line(
        "Whole steps, each one launch of a captured graph, as the device's clock has them; means, "
        "so that they hold full passes and the steps between them. Rays, walks and contacts are a "
        "step's. *Certified* runs as *off* on a GPU. Piles are shown in two phases of their "
        "motion.");
    const auto table = on_gpu(options, page, "tables_2_3_gpu", [&](const KeepTable& keep) {
        return measure_all(piles, options, keep);
    });
    if (!table) return;
    page.line(
        "\n| scene, bodies | off [ms] | paper [ms] | + prediction [ms] | certified [ms] | "
        "off / paper | prediction costs | rays: off | paper: rays, walks, lost | + prediction: "
        "rays, walks | contacts: off, paper, + prediction |\n|---|---|---|---|---|---|---|---|---|"
        "---|---|");
    for (std::size_t i = 0; i < table->rows.size(); ++i) {
        const std::vector<double>& r = table->rows[i];
        page.line(
            "| {}, {:g} | {:.4f} | {:.4f} | {:.4f} | {:.4f} | {:.2f} | {:+.1f} % | {:.0f} | "
            "{:.0f}, {:.0f}, {:.0f} | {:.0f}, {:.0f} | {:.0f}, {:.0f}, {:.0f} |",
            table->labels[i], r[0], r[1], r[2], r[3], r[4], r[1] / r[2], 100 * (r[3] / r[2] - 1),
            r[5], r[6], r[7], r[8], r[9], r[10], r[11], r[12], r[13]);
    }
}

}  // namespace pierce::app
