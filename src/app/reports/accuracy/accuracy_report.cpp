#include "app/reports/accuracy/accuracy_report.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/measure/compare.hpp"
#include "app/output/frame_log.hpp"
#include "app/output/page.hpp"
#include "app/reports/accuracy/accuracy_figures.hpp"
#include "app/reports/accuracy/damaged_meshes.hpp"
#include "app/reports/accuracy/hard_case_table.hpp"

namespace pierce::app {
namespace {

/// Median and 95th percentile, or a dash if there is nothing.
std::string two(const std::vector<double>& values, double scale) {
    const Spread spread = spread_of(values);
    return values.empty()
               ? "-"
               : fmt::format("{:.3f}, {:.2f}", scale * spread.median, scale * spread.p95);
}

/// The main plot of a motion, and a table of all figures.
void speed_against_error_of(const std::string& name, const std::string& bodies,
                            const scenes::Recording& recording,
                            const AccuracyReportOptions& options, Page& page) {
    const std::vector<scenes::TrueFrame> truth = truth_of(recording, options.every);
    std::vector<std::string> left_out;
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t used = std::clock();
    const std::vector<Comparison> results = compare(
        recording, truth, compared_methods(), options.threads, "comparing " + name, &left_out);

    const double processor = static_cast<double>(std::clock() - used) / CLOCKS_PER_SEC;
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;

    page.line("### {}\n", name);
    page.line("{} and the ground, {} frames, {} of them with the truth.", bodies,
              recording.frame_count, truth.size());
    page.line(
        "The comparison took {:.1f} s of processor time in {:.1f} s. Other work, if there was, "
        "makes long frames longer.",
        processor, wall.count());
    page.plot(speed_against_error(figures_of(results), bodies), "f1_" + name);
    page.line(
        "| method | ms a frame, median | missed pairs | false pairs | missed vertices [%] | missed "
        "depth [%] | depth / "
        "true: "
        "median, p95 | normal off [deg]: median, p95 | pair depth / deepest vertex "
        "|\n|---|---|---|---|---|---|---|---|---|");
    for (const Comparison& c : results) {
        const scenes::Accuracy& a = c.accuracy;
        page.line("| {} | {:.3f} | {} of {} | {} | {:.3f} | {:.3f} | {} | {} | {:.3f} |", c.name,
                  c.median_ms(), a.missed_pairs, a.pairs, a.false_pairs,
                  100 * a.missed_vertex_share(), 100 * a.missed_share(), two(a.depth_ratios, 1),
                  two(a.normal_errors, 180 / std::numbers::pi), a.pair_depth_ratio());
    }
    page.line("");
    for (const std::string& line : left_out) page.line("Left out: {}.\n", line);
}

void falling_bodies(const std::string& scene, bool soft, const AccuracyReportOptions& options,
                    Page& page) {
    const std::uint32_t count = soft ? (options.count + 3) / 4 : options.count;  // they are
                                                                                 // simulated slowly
    const scenes::Recording recording = simulate(
                                            scenes::make_scene(scene, {count, soft, options.seed}),
                                            scenes::Method::rays, {}, options.timing)
                                            .recording;
    speed_against_error_of(scene + (soft ? "_soft" : ""),
                           fmt::format("{} {} {}", count, soft ? "soft" : "rigid", scene),
                           recording, options, page);
}

/// Bodies whose meshes change.
void torn_bodies(const AccuracyReportOptions& options, Page& page) {
    constexpr double until_all_lies = 6;  // [s]
    const scenes::SceneSetup scene = scenes::make_scene("tear", {.seed = options.seed});
    const scenes::Recording recording = simulate(scene, scenes::Method::rays, {},
                                                 {std::min(options.timing.seconds, until_all_lies),
                                                  scene.dt})
                                            .recording;
    std::size_t changes = 0;
    for (const scenes::RecordedBody& body : recording.bodies) changes += body.mesh_changes.size();
    speed_against_error_of("tear",
                           fmt::format("A sheet and a soft solid whose meshes change {} times "
                                       "while they tear",
                                       changes),
                           recording, options, page);
}

}  // namespace

int report_accuracy(const AccuracyReportOptions& options) {
    Page page(options.out, "Time and error, measured here",
              {{"seed", options.seed},
               {"threads for rays", options.threads},
               {"count", options.count},
               {"seconds", options.timing.seconds},
               {"every", options.every},
               {"poses", options.poses},
               {"rays", options.rays}},
              options.html);
    page.line("## Speed against error\n");
    page.line("{:g} s at {:g} s a step; the truth is known of one frame in {}.\n",
              options.timing.seconds, options.timing.dt, options.every);
    const Page::Part parts[] = {
        {"tori", [&] { falling_bodies("tori", false, options, page); }},
        {"bunnies", [&] { falling_bodies("bunnies", false, options, page); }},
        {"soft tori", [&] { falling_bodies("tori", true, options, page); }},
        {"tear", [&] { torn_bodies(options, page); }},
        {"leaks", [&] { leaks_figure(options, page); }},
        {"resolution", [&] { resolution_figure(options, page); }},
        {"depth", [&] { depth_figure(options, page); }},
        {"damaged meshes", [&] { damaged_meshes(options, page); }},
        {"hard cases", [&] {
             page.line("## The hard cases\n");
             hard_case_table(page);
         }}};
    page.write(parts);
    return 0;
}

}  // namespace pierce::app
