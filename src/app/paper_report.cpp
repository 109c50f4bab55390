#include "paper_report.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "frame_log.hpp"
#include "page.hpp"
#include "pierce/core/error.hpp"
#include "pierce/core/world.hpp"
#include "pierce/scenes/contact_error.hpp"
#include "pierce/scenes/detector.hpp"
#include "pierce/scenes/recording.hpp"
#include "pierce/scenes/simulation.hpp"
#include "plot.hpp"
#include "progress.hpp"
#include "record_scene.hpp"

namespace pierce::app {
namespace {

namespace fs = std::filesystem;
using scenes::ContactComparison;
using scenes::ContactError;
using scenes::Detector;
using scenes::Method;
using scenes::Recording;

/// A way of detecting, and what came of it on a recording.
struct Mode {
    std::string name;
    Settings settings;
    std::unique_ptr<Detector> detector;
    ContactComparison comparison;
    std::vector<double> narrow_ms;  ///< of the frames that count
    std::uint64_t rays = 0, walks = 0, walk_steps = 0, lost = 0;

    double median_ms() const { return spread_of(narrow_ms).median; }
};

Mode mode(std::string name, Temporal temporal, bool predict) {
    Mode m;
    m.name = std::move(name);
    m.settings.temporal = temporal;
    m.settings.predict = predict;
    return m;
}

/// All modes on the same frames, taking turns frame by frame on one thread; times count from the middle of the recording,
/// errors from its beginning. The first mode is the truth of the others.
void measure(const Recording& recording, std::vector<Mode>& modes, const std::string& what) {
    for (Mode& m : modes)
        m.detector = scenes::make_detector(scenes::scene_of(recording), Method::rays, {"embree", 1, m.settings});
    Progress progress(what, recording.frame_count);
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        for (Mode& m : modes) {
            scenes::put_frame(*m.detector, recording, f);
            const scenes::FrameResult result = m.detector->detect();
            m.comparison.add(modes[0].detector->world()->contacts(), m.detector->world()->contacts());
            if (f < recording.frame_count / 2) continue;
            m.narrow_ms.push_back(result.narrow_ms);
            m.rays += result.rays;
            m.walks += result.walks;
            m.walk_steps += result.walk_steps;
            m.lost += result.lost_walks;
        }
        progress.show(f + 1);
    }
    for (Mode& m : modes) m.detector.reset();
}

/// Tables 2 and 3: what iterative rays save, and what prediction costs.
void tables_2_and_3(const std::vector<std::pair<std::string, Recording>>& recordings, Page& page, const fs::path& folder) {
    struct Figures {
        const char* scene;
        const char* full;
        const char* iterative;
        const char* predictive;
    };
    constexpr Figures paper[] = {{"tori", "56.7", "36.2", "37.2"}, {"bunnies", "129.2", "116.3", "118.6"}};
    Table table{{"scene", "off_ms", "paper_ms", "predict_ms", "certified_ms", "paper_missed_depth", "predict_missed_depth"},
                {}};

    page.line("## Tables 2 and 3: iterative and predictive rays\n");
    page.line(
        "Narrow phase per frame: median over the second half of the motion, one thread, all modes on the same frames in "
        "turn.");
    page.line(
        "*Off* traces every vertex that is not culled; *paper* walks from the last hits; *certified* leaves out what is "
        "proved to be");
    page.line("needless and has the contacts of *off*, all of them.\n");
    page.line(
        "| scene | off [ms] | paper [ms] | + prediction [ms] | certified [ms] | off / paper | paper's 1.57, 1.11 | "
        "prediction costs | "
        "paper's 2.8 %, 2.0 % | off / certified |");
    page.line("|---|---|---|---|---|---|---|---|---|---|");
    std::string errors =
        "\n| scene | mode | missed contacts | of the depth | missed when they began | late by, mean and most [steps] | at "
        "another triangle | not "
        "there |\n|---|---|---|---|---|---|---|---|\n";
    for (std::size_t s = 0; s < recordings.size(); ++s) {
        const auto& [name, recording] = recordings[s];
        std::vector<Mode> modes;
        modes.push_back(mode("off", Temporal::off, false));
        modes.push_back(mode("paper", Temporal::paper, false));
        modes.push_back(mode("paper, predicting", Temporal::paper, true));
        modes.push_back(mode("certified", Temporal::certified, false));
        measure(recording, modes, "tables 2 and 3, " + name);
        const double off = modes[0].median_ms(), walking = modes[1].median_ms(), predicting = modes[2].median_ms(),
                     certified = modes[3].median_ms();
        const bool bunnies = name.find("bunnies") != std::string::npos;
        const bool soft = name.find("soft") != std::string::npos;
        page.line("| {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.2f} | {} | {:+.1f} % | {} | {:.2f} |", name, off, walking,
                  predicting, certified, off / walking,
                  soft      ? "-"
                  : bunnies ? "1.11"
                            : "1.57",
                  100 * (predicting / walking - 1),
                  soft      ? "-"
                  : bunnies ? "+2.0 %"
                            : "+2.8 %",
                  off / certified);
        for (std::size_t m = 1; m < modes.size(); ++m) {
            const ContactError& e = modes[m].comparison.error();
            errors += fmt::format(
                "| {} | {} | {} of {} | {:.3f} % | {} of {} | {:.1f}, {} | {} | {} |\n", name, modes[m].name, e.missed,
                e.expected, 100 * e.missed_share(), e.first_missed, e.first,
                e.first_missed > 0 ? static_cast<double>(e.late_steps) / static_cast<double>(e.first_missed) : 0.0, e.latest,
                e.wrong, e.added);
        }
        table.rows.push_back({static_cast<double>(s), off, walking, predicting, certified,
                              modes[1].comparison.error().missed_share(), modes[2].comparison.error().missed_share()});
    }
    page.line("\nThe paper, in milliseconds: ");
    for (const Figures& f : paper)
        page.line("{} {} full, {} iterative, {} with prediction;", f.scene, f.full, f.iterative, f.predictive);
    page.line("\nWhat these times cost in contacts, against *off*, over the whole motion:");
    page.line("{}", errors);
    table.write_csv(folder / "tables_2_3.csv");
}

/// F4: what the threshold costs.
void threshold_map(const std::string& name, const Recording& recording, Page& page, const fs::path& folder) {
    std::vector<Mode> modes;
    modes.push_back(mode("off", Temporal::off, false));
    const double thresholds[] = {0.1, 0.5, 1, 2, 4, 8};
    for (double threshold : thresholds) {
        modes.push_back(mode(fmt::format("{}", threshold), Temporal::paper, true));
        modes.back().settings.walk_threshold = threshold;
        modes.back().settings.full_every = 64;  // so that the threshold decides, not the period
    }
    measure(recording, modes, "threshold, " + name);
    Curves curves{"What the walk threshold costs, " + name,
                  "displacement allowed since the last full ray [edges]",
                  "per cent, steps, ratio",
                  {{"threshold", "missed depth [%]", "wrong triangle [%]", "lost walks [%]", "steps per walk",
                    "off / this, narrow phase"},
                   {}},
                  true};
    for (std::size_t m = 1; m < modes.size(); ++m) {
        const ContactError& e = modes[m].comparison.error();
        const auto walks = static_cast<double>(std::max<std::uint64_t>(modes[m].walks, 1));
        curves.table.rows.push_back({thresholds[m - 1], 100 * e.missed_share(), 100 * e.wrong_share(),
                                     100 * static_cast<double>(modes[m].lost) / walks,
                                     static_cast<double>(modes[m].walk_steps) / walks,
                                     modes[0].median_ms() / modes[m].median_ms()});
    }
    page.picture(write_plot(curves, folder, "f4_threshold_" + name), "f4_threshold_" + name);
}

/// F12: full passes every K steps against how far predictions look.
void period_map(const std::string& name, const Recording& recording, Page& page, const fs::path& folder) {
    const double periods[] = {1, 2, 4, 8, 16, 32};
    const double reaches[] = {0, 0.125, 0.25, 0.5, 1};
    double edge = 0;  // of the falling bodies' mesh
    {
        const scenes::SceneSetup scene = scenes::scene_of(recording);
        for (const scenes::SceneBody& body : scene.bodies)
            if (!body.ground)
                edge = Mesh(scene.meshes[body.mesh].name, scene.meshes[body.mesh].data).traits().mean_edge_length;
    }
    std::vector<Mode> modes;
    modes.push_back(mode("off", Temporal::off, false));
    for (double reach : reaches)
        for (double period : periods) {
            modes.push_back(mode(fmt::format("{} {}", period, reach), Temporal::paper, reach > 0));
            modes.back().settings.full_every = static_cast<std::uint32_t>(period);
            modes.back().settings.prediction_distance = reach * edge;
        }
    measure(recording, modes, "period, " + name);
    HeatMap missed{"Contacts missed in their first frame, " + name,
                   "full pass every K steps",
                   "predictions look ahead [edges]",
                   "per cent",
                   {{"K", "reach", "missed_percent"}, {}}};
    HeatMap time{"Narrow phase, " + name,
                 "full pass every K steps",
                 "predictions look ahead [edges]",
                 "off / this",
                 {{"K", "reach", "off_over_this"}, {}}};
    std::size_t m = 1;
    for (double reach : reaches)
        for (double period : periods) {
            const ContactError& e = modes[m].comparison.error();
            missed.table.rows.push_back(
                {period, reach,
                 100 * static_cast<double>(e.first_missed) / static_cast<double>(std::max<std::uint64_t>(e.first, 1))});
            time.table.rows.push_back({period, reach, modes[0].median_ms() / modes[m].median_ms()});
            ++m;
        }
    page.picture(write_plot(missed, folder, "f12_missed_" + name), "f12_missed_" + name);
    page.picture(write_plot(time, folder, "f12_time_" + name), "f12_time_" + name);
}

/// Figure 9: the loop closed, with and without prediction. Depths are those of all contacts there are, traced anew in every
/// frame.
void figure_9(const PaperReportOptions& options, Page& page, const fs::path& folder) {
    const scenes::SceneSetup scene = scenes::make_scene("tori", {options.count, false, options.seed});
    Curves curves{"Penetration over time, tori, loop closed",
                  "time [s]",
                  "mean depth of all contacts",
                  {{"time", "paper's rays", "with prediction", "all rays (off)"}, {}}};
    const auto steps = static_cast<std::uint32_t>(std::lround(options.seconds / options.dt));
    const Settings settings[3] = {mode("", Temporal::paper, false).settings, mode("", Temporal::paper, true).settings,
                                  mode("", Temporal::off, false).settings};
    constexpr std::uint32_t window = 12;  // frames per point of the curve
    std::vector<std::vector<double>> depth(3);
    double mean[3] = {}, deepest[3] = {};
    for (int k = 0; k < 3; ++k) {
        scenes::Simulation simulation(scene, Method::rays, {"embree", 0, settings[k]});
        scenes::SceneWorld truth(scene, {"embree", 0, settings[2]});
        Progress progress("figure 9", steps);
        for (std::uint32_t i = 0; i < steps; ++i) {
            Recording now = scenes::start_recording(scene, options.dt);
            simulation.record(now);
            for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) truth.world.set_pose(truth.bodies[b], now.pose(b, 0));
            const StepStats& stats = truth.world.detect();
            depth[static_cast<std::size_t>(k)].push_back(stats.penetration_mean);
            mean[k] += stats.penetration_mean / steps;
            deepest[k] = std::max(deepest[k], stats.penetration_max);
            simulation.step(options.dt);
            progress.show(i + 1);
        }
    }
    for (std::uint32_t begin = 0; begin + window <= steps; begin += window) {
        std::vector<double> row{(begin + 0.5 * window) * options.dt};
        for (const auto& values : depth) {
            double sum = 0;
            for (std::uint32_t i = begin; i < begin + window; ++i) sum += values[i];
            row.push_back(sum / window);
        }
        curves.table.rows.push_back(std::move(row));
    }
    page.line("## Figure 9: penetration with and without prediction\n");
    page.line(
        "{} tori, the loop closed, a full pass every {} steps. Each run has a motion of its own; depths are those of all "
        "its contacts.\n",
        options.count, settings[0].full_every);
    page.line("| | mean depth over the run | deepest |\n|---|---|---|");
    const char* names[] = {"iterative rays", "iterative and predictive rays", "all rays, every step"};
    for (int k = 0; k < 3; ++k) page.line("| {} | {:.5f} | {:.4f} |", names[k], mean[k], deepest[k]);
    page.picture(write_plot(curves, folder, "figure_9"), "figure_9");
}

}  // namespace

int report_paper(const PaperReportOptions& options) {
    const fs::path& folder = options.out;
    Page page(folder);
    page.line("# The paper's experiments, measured here\n");
    page.line("{}\n{} bodies, {:g} s at {:g} s a step, seed {}.\n", machine_json().dump(), options.count, options.seconds,
              options.dt, options.seed);

    std::vector<std::pair<std::string, Recording>> recordings;
    for (bool soft : {false, true})
        for (const char* scene : {"tori", "bunnies"})
            recordings.emplace_back(std::string(scene) + (soft ? "_soft" : ""),
                                    record_scene(scene, {options.count, soft, options.seed}, options.seconds, options.dt));
    tables_2_and_3(recordings, page, folder);
    page.line("## What threshold and period cost\n");
    for (std::size_t s = 0; s < 2; ++s) {
        threshold_map(recordings[s].first, recordings[s].second, page, folder);
        period_map(recordings[s].first, recordings[s].second, page, folder);
    }
    figure_9(options, page, folder);
    page.close();
    return 0;
}

}  // namespace pierce::app
