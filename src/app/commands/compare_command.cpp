#include "app/commands/compare_command.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/commands/detection_page.hpp"
#include "app/measure/compare.hpp"
#include "app/measure/recording_files.hpp"
#include "app/output/frame_log.hpp"
#include "app/output/json_file.hpp"
#include "app/output/provenance.hpp"
#include "app/reports/accuracy/accuracy_figures.hpp"

namespace pierce::app {

using nlohmann::json;
using scenes::Accuracy;

namespace {

json to_json(const Comparison& c) {
    const Accuracy& a = c.accuracy;
    const Spread ms = spread_of(c.ms);
    return {
        {"method", c.name},
        {"ms", {{"median", ms.median}, {"p95", ms.p95}, {"max", ms.max}}},
        {"contacts_per_frame", c.contacts},
        {"pairs", a.pairs},
        {"missed_pairs", a.missed_pairs},
        {"false_pairs", a.false_pairs},
        {"vertices", a.vertices},
        {"missed_vertices", a.missed_vertices},
        {"false_vertices", a.false_vertices},
        {"missed_depth_share", a.missed_share()},
        {"missed_pair_depth_share", a.missed_pair_share()},
        {"depth_ratio",
         {{"median", spread_of(a.depth_ratios).median}, {"p95", spread_of(a.depth_ratios).p95}}},
        {"normal_error_degrees",
         {{"median", degrees(spread_of(a.normal_errors).median)},
          {"p95", degrees(spread_of(a.normal_errors).p95)}}},
        {"pair_depth_ratio", a.pair_depth_ratio()}};
}

/// What the page's charts show of every frame: time beside error.
std::vector<json> frames_json(std::span<const Comparison> results) {
    std::vector<json> frames;
    for (const Comparison& c : results) {
        frames.resize(c.ms.size());
        for (std::size_t f = 0; f < frames.size(); ++f) {
            frames[f]["ms"][c.name] = c.ms[f];
            frames[f]["missed part of the depth"][c.name] = c.missed_shares[f];
        }
    }
    return frames;
}

json table_json(std::span<const Comparison> results) {
    const Table figures = figures_of(results);
    json columns = json::array({"method"}), rows = json::array();
    for (std::string name : figures.names) {
        std::ranges::replace(name, '_', ' ');
        columns.push_back(name);
    }
    for (std::size_t r = 0; r < figures.rows.size(); ++r) {
        json row = json::array({figures.labels[r]});
        for (double value : figures.rows[r]) row.push_back(value);
        rows.push_back(row);
    }
    return {{"title", "Time and error of all methods"}, {"columns", columns}, {"rows", rows}};
}

void print(std::span<const Comparison> results) {
    fmt::print("  {:<13}{:>9}{:>17}{:>8}{:>11}{:>11}{:>16}{:>18}{:>12}\n", "", "ms/frame",
               "missed pairs", "false", "missed", "missed", "depth / true", "normal off [deg]",
               "pair depth");
    fmt::print("  {:<13}{:>9}{:>17}{:>8}{:>11}{:>11}{:>16}{:>18}{:>12}\n", "method", "median",
               "of all", "pairs", "vertices", "depth", "median, p95", "median, p95", "/ vertices'");
    for (const Comparison& c : results) {
        const Accuracy& a = c.accuracy;
        const auto two = [](const std::vector<double>& values, double scale) {
            return values.empty() ? std::string("-")
                                  : fmt::format("{:.3f}, {:.2f}", scale * spread_of(values).median,
                                                scale * spread_of(values).p95);
        };
        fmt::print("  {:<13}{:>9.3f}{:>17}{:>8}{:>10.3f}%{:>10.3f}%{:>16}{:>18}{:>12.3f}\n", c.name,
                   c.median_ms(), fmt::format("{} of {}", a.missed_pairs, a.pairs), a.false_pairs,
                   100 * a.missed_vertex_share(), 100 * a.missed_share(), two(a.depth_ratios, 1),
                   two(a.normal_errors, 180 / std::numbers::pi), a.pair_depth_ratio());
    }
}

}  // namespace

int compare_recording(const CompareOptions& options) {
    const scenes::Recording recording = load_recording(options.folder);
    std::vector<ComparedMethod> methods;
    methods.reserve(options.methods.size());
    for (const std::string& name : options.methods) methods.push_back(compared_method_named(name));
    if (methods.empty()) methods.assign(compared_methods().begin(), compared_methods().end());
    check_writable(options.json);
    check_writable(options.page.file);
    check_different({options.json, options.page.file});
    check_folder_writable(options.plots);
    const std::vector<scenes::TrueFrame> truth = truth_of(options.folder, options.every);
    std::vector<std::string> left_out;
    const std::vector<Comparison> results = compare(recording, truth, methods, options.threads,
                                                    "comparing",
                                                    options.methods.empty() ? &left_out : nullptr);

    fmt::print("{}: {} bodies, {} frames, {} of them with the truth, {} thread{}\n",
               options.folder.string(), recording.bodies.size(), recording.frame_count,
               truth.size(), options.threads, options.threads == 1 ? "" : "s");
    print(results);
    for (const std::string& line : left_out) fmt::print("  left out: {}\n", line);
    const json settings{
        {"command", "compare"},
        {"folder", options.folder.filename().string()},
        {"threads", options.threads},
        {"every", truth.size() > 1 ? sampling_of(truth) : options.every.value_or(usual_truth)}};
    if (!options.json.empty()) {
        json list = json::array();
        for (const Comparison& c : results) list.push_back(to_json(c));
        write_json_file(options.json, {{"machine", machine_json()},
                                       {"versions", versions_json()},
                                       {"settings", settings},
                                       {"methods", list}});
    }
    if (!options.plots.empty()) {
        write_plot(speed_against_error(figures_of(results), options.folder.filename().string()),
                   options.plots, "f1_speed_against_error",
                   json{{"machine", machine_json()}, {"versions", versions_json()}}.dump());
    }
    scenes::RaySettings rays;
    rays.threads = options.threads;
    write_page_of(recording, options.page, rays, options.folder.filename().string(),
                  frames_json(results), 1, settings, json::array({table_json(results)}),
                  options.folder);
    return 0;
}

}  // namespace pierce::app
