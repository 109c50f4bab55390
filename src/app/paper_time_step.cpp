#include <algorithm>
#include <cmath>
#include <set>

#include "paper_motion.hpp"
#include "paper_sections.hpp"
#include "pierce/scenes/simulation.hpp"
#include "progress.hpp"
#include "statistics.hpp"

namespace pierce::app {
namespace {

constexpr int least_step = 2, most_step = 8;       // [s/120]
constexpr double paper_begin = 3, paper_end = 10;  // [s]

/// Depth of a frame's contacts, or the mean of that over frames.
struct Depth {
    double mean = 0, max = 0, deviation = 0;
};

constexpr double Depth::*depth_numbers[] = {&Depth::mean, &Depth::max, &Depth::deviation};
constexpr const char* depth_names[] = {"mean", "maximum", "standard deviation"};

Depth depth_of(std::span<const Contact> contacts) {
    std::vector<double> depths;
    for (const Contact& c : contacts) depths.push_back(c.penetration_depth());
    return {mean(depths), depths.empty() ? 0 : std::ranges::max(depths), deviation(depths)};
}

std::vector<double> column(std::span<const Depth> depths, double Depth::*number) {
    std::vector<double> values;
    for (const Depth& d : depths) values.push_back(d.*number);
    return values;
}

Depth mean_of(std::span<const Depth> frames) {
    Depth result;
    for (double Depth::*number : depth_numbers) result.*number = mean(column(frames, number));
    return result;
}

/// Mean depths of a run: while bodies land, and in the seconds the paper looked at.
struct Run {
    Depth landing, paper_seconds;
    double begin = 0, end = 0;  ///< [s] of the landing: from the first contact to the last body's first one
};

Run run(const scenes::SceneSetup& scene, double dt) {
    scenes::Simulation simulation(scene, scenes::Method::rays);
    std::vector<Depth> depths;
    std::set<std::uint32_t> landed;
    std::size_t first = 0, last = 0;
    const auto steps = Timing{paper_end, dt}.steps();
    for (std::uint32_t i = 0; i < steps; ++i) {
        const scenes::FrameResult& found = simulation.step(dt);
        depths.push_back(depth_of(simulation.world()->contacts()));
        const std::size_t before = landed.size();
        for (const auto& [a, b] : found.touching) landed.insert({a, b});
        if (before == 0 && !landed.empty()) first = i;
        if (landed.size() > before) last = i;
    }
    const auto paper_first = static_cast<std::size_t>(std::lround(paper_begin / dt));
    const std::span all(depths);
    return {mean_of(all.subspan(first, last + 1 - first)), mean_of(all.subspan(paper_first)),
            static_cast<double>(first) * dt, static_cast<double>(last) * dt};
}

void fit_lines(const char* when, std::span<const double> dts, std::span<const Depth> depths, Page& page) {
    for (std::size_t n = 0; n < std::size(depth_numbers); ++n) {
        const LinearFit fit = linear_fit(dts, column(depths, depth_numbers[n]));
        page.line("| {} | {} | {:.4f} | {:.4f} | {:.4f} |", when, depth_names[n], fit.slope, fit.offset, fit.r2);
    }
}

}  // namespace

void figure_14(const PaperReportOptions& options, Page& page) {
    std::vector<double> dts, begins, ends;
    std::vector<Depth> landing, paper_seconds;  // by time step
    Progress progress("figure 14", (most_step - least_step + 1) * options.runs);
    std::uint32_t done = 0;
    for (int k = least_step; k <= most_step; ++k) {
        std::vector<Depth> of_landing, of_paper_seconds;  // by run
        dts.push_back(k / 120.0);
        for (std::uint32_t r = 0; r < options.runs; ++r) {
            const Run made = run(scenes::make_scene("tori", {options.count, false, options.seed + r}), dts.back());
            of_landing.push_back(made.landing);
            of_paper_seconds.push_back(made.paper_seconds);
            begins.push_back(made.begin);
            ends.push_back(made.end);
            progress.show(++done);
        }
        landing.push_back(mean_of(of_landing));
        paper_seconds.push_back(mean_of(of_paper_seconds));
    }

    page.line("## Figure 14: penetration against the time step\n");
    page.line(
        "{} tori, the loop closed by rays, mean of {} runs with seeds from {}. Of each frame's contacts the mean, the "
        "maximum "
        "and the standard deviation of the depth, then the mean over the frames while tori land: from the first contact of "
        "any to the first contact of the last one, as in the paper. There this is from 3 to 10 s, here from {:.2f} to "
        "{:.2f} s; "
        "from 3 s on the tori here only come to rest.\n",
        options.count, options.runs, options.seed, mean(begins), mean(ends));
    page.line("| step [s] | mean | maximum | standard deviation |\n|---|---|---|---|");
    Table table{{"dt", "mean", "maximum", "standard deviation"}, {}};
    for (std::size_t i = 0; i < dts.size(); ++i) {
        const Depth& d = landing[i];
        page.line("| {}/120 | {:.4f} | {:.4f} | {:.4f} |", least_step + static_cast<int>(i), d.mean, d.max, d.deviation);
        table.rows.push_back({dts[i], d.mean, d.max, d.deviation});
    }
    page.line("\nThe paper: \"all three lines show a near linear change with the time-step\". Least squares:\n");
    page.line("| frames | depth | slope [1/s] | offset | R² |\n|---|---|---|---|---|");
    fit_lines("while tori land", dts, landing, page);
    fit_lines("3 to 10 s", dts, paper_seconds, page);
    page.plot(
        Curves{"Penetration against the time step, tori, loop closed", "time step [s]", "depth while tori land", table},
        "figure_14");
}

}  // namespace pierce::app
