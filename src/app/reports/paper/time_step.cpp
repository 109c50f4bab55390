#include <algorithm>
#include <cmath>
#include <set>

#include "app/measure/in_parallel.hpp"
#include "app/measure/motion.hpp"
#include "app/output/progress.hpp"
#include "app/output/statistics.hpp"
#include "app/reports/paper/sections.hpp"
#include "scenes/simulate/simulation.hpp"

namespace pierce::app {
namespace {

constexpr int least_step = 2, most_step = 8;  // [s/120]
constexpr double paper_begin = 3;             // [s]

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
    double begin = 0, end = 0;  ///< [s] of the landing: from the first contact to the last body's
                                ///< first one
};

Run run(const scenes::SceneSetup& scene, double seconds, double dt) {
    scenes::Simulation simulation(scene, scenes::Method::rays,
                                  {.threads = 1, .world = vertex_rays});
    std::vector<Depth> depths;
    std::set<std::uint32_t> landed;
    std::size_t first = 0, last = 0;
    const auto steps = Timing{seconds, dt}.steps();
    for (std::uint32_t i = 0; i < steps; ++i) {
        const scenes::FrameResult& found = simulation.step(dt);
        depths.push_back(depth_of(simulation.world()->contacts()));
        const std::size_t before = landed.size();
        for (const auto& [a, b] : found.touching) landed.insert({a, b});
        if (before == 0 && !landed.empty()) first = i;
        if (landed.size() > before) last = i;
    }
    const auto paper_first = std::min<std::size_t>(
        static_cast<std::size_t>(std::lround(paper_begin / dt)), steps);
    const std::span all(depths);
    return {mean_of(all.subspan(first, last + 1 - first)), mean_of(all.subspan(paper_first)),
            static_cast<double>(first) * dt, static_cast<double>(last) * dt};
}

/// Depths by time step, their lines of least squares, and the picture of both.
void write_phase(const char* phase, const std::string& pile, const std::string& name,
                 std::span<const double> dts, std::span<const Depth> depths, Page& page) {
    Table table{{"dt"}, {}};
    std::vector<Line> lines;
    for (double dt : dts) table.rows.push_back({dt});
    page.line("| {} | slope [1/s] | offset | R² |\n|---|---|---|---|", phase);
    for (std::size_t n = 0; n < std::size(depth_numbers); ++n) {
        const std::vector<double> values = column(depths, depth_numbers[n]);
        const LinearFit fit = linear_fit(dts, values);
        page.line("| {} | {:.4f} | {:.4f} | {:.4f} |", depth_names[n], fit.slope, fit.offset,
                  fit.r2);
        table.names.insert(table.names.end(),
                           {depth_names[n], fmt::format("{} (line)", depth_names[n])});
        lines.push_back({.look = depth_names[n], .stroke = Stroke::points});
        lines.push_back(
            {.look = depth_names[n], .note = "line of least squares", .stroke = Stroke::bare});
        for (std::size_t i = 0; i < dts.size(); ++i)
            table.rows[i].insert(table.rows[i].end(), {values[i], fit.offset + fit.slope * dts[i]});
    }
    page.plot(Curves{.title = fmt::format("Penetration against the time step, {}, loop closed, {}",
                                          pile, phase),
                     .x = "time step [s]",
                     .y = {"mean over frames of a frame's depth [length]"},
                     .table = table,
                     .lines = lines},
              name);
}

}  // namespace

void figure_14(const Pile& pile, const PaperReportOptions& options, Page& page) {
    const auto bodies = static_cast<std::uint32_t>(pile.scene.bodies.size()) - 1;
    const std::uint32_t runs = pile.soft ? 1 : options.runs;
    std::vector<double> dts, begins, ends;
    std::vector<Depth> landing, paper_seconds;  // by time step
    Progress progress("figure 14, " + pile.name, (most_step - least_step + 1) * runs);
    for (int k = least_step; k <= most_step; ++k) dts.push_back(k / 120.0);
    std::vector<Run> all(dts.size() * runs);
    in_parallel("making figure 14", all.size(), [&](std::size_t i) {
        const auto seed = options.seed + static_cast<std::uint32_t>(i % runs);
        all[i] = run(scenes::make_scene(pile.scene.name, {bodies, pile.soft, seed}),
                     options.landing_seconds, dts[i / runs]);
        progress.one_more();
    });
    for (std::size_t k = 0; k < dts.size(); ++k) {
        std::vector<Depth> of_landing, of_paper_seconds;  // by run
        for (const Run& made : std::span(all).subspan(k * runs, runs)) {
            of_landing.push_back(made.landing);
            of_paper_seconds.push_back(made.paper_seconds);
            begins.push_back(made.begin);
            ends.push_back(made.end);
        }
        landing.push_back(mean_of(of_landing));
        paper_seconds.push_back(mean_of(of_paper_seconds));
    }

    page.line("\n### {}\n", pile.name);
    page.line(
        "{} bodies, the loop closed by rays, mean of {} runs with seeds from {}. Of the depths of "
        "a frame's contacts the mean, the maximum and the standard deviation, each averaged over "
        "the frames while they land: from the first contact of any to the first contact of the "
        "last one. In the paper this is from 3 to 10 s, here from {:.2f} to {:.2f} s. The frames "
        "from 3 s to the end are shown, too.\n",
        bodies, runs, options.seed, mean(begins), mean(ends));
    page.line(
        "| step [s] | mean | maximum | standard deviation | 3 s to the end: mean | maximum | "
        "standard deviation |");
    page.line("|---|---|---|---|---|---|---|");
    for (std::size_t i = 0; i < dts.size(); ++i) {
        const Depth &a = landing[i], &b = paper_seconds[i];
        page.line("| {}/120 | {:.4f} | {:.4f} | {:.4f} | {:.4f} | {:.4f} | {:.4f} |",
                  least_step + static_cast<int>(i), a.mean, a.max, a.deviation, b.mean, b.max,
                  b.deviation);
    }
    page.line(
        "\nThe paper: \"all three lines show a near linear change with the time-step\". Lines of "
        "least squares:\n");
    write_phase("while they land", pile.title(), "figure_14_" + pile.name, dts, landing, page);
    write_phase("3 s to the end", pile.title(), "figure_14_from_3_s_" + pile.name, dts,
                paper_seconds, page);
}

}  // namespace pierce::app
