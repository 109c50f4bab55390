#include "app/compare.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <numbers>

#include "app/commands.hpp"
#include "app/frame_log.hpp"
#include "app/plot.hpp"
#include "app/progress.hpp"
#include "pierce/error.hpp"
#include "scenes/detector.hpp"

namespace pierce::app {

namespace fs = std::filesystem;
using nlohmann::json;
using scenes::Accuracy;
using scenes::Method;

std::span<const ComparedMethod> compared_methods() {
    static const std::vector<ComparedMethod> methods{
        {"full", Method::rays, {.temporal = Temporal::off}},
        {"walk", Method::rays, {.temporal = Temporal::paper, .predict = false}},
        {"walk-predict", Method::rays, {.temporal = Temporal::paper}},
        {"certified", Method::rays, {.temporal = Temporal::certified}},
        {"complete", Method::rays, {.coverage = Coverage::complete}},
        {"reprojected", Method::rays, {.coverage = Coverage::complete, .reproject = true}},
        {"gjk-hull", Method::gjk_hull, {}},
        {"gjk-epa", Method::gjk_epa, {}},
        {"gimpact", Method::gimpact, {}}};
    return methods;
}

const ComparedMethod& compared_method_named(const std::string& name) {
    std::string known;
    for (const ComparedMethod& m : compared_methods()) {
        if (m.name == name) return m;
        known += (known.empty() ? "" : ", ") + m.name;
    }
    throw InputError("unknown method '" + name + "'; there are: " + known);
}

double Comparison::median_ms() const { return spread_of(ms).median; }

std::vector<Comparison> compare(const scenes::Recording& recording,
                                std::span<const scenes::TrueFrame> truth,
                                std::span<const ComparedMethod> methods, int threads,
                                const std::string& what, std::vector<std::string>* left_out) {
    scenes::SceneSetup scene = scenes::scene_of(recording);
    add_convex_pieces(scene);
    std::vector<Comparison> results;
    std::vector<std::unique_ptr<scenes::Detector>> detectors;
    std::vector<scenes::AccuracyCount> counts;
    for (const ComparedMethod& m : methods) {
        try {
            detectors.push_back(
                scenes::make_detector(scene, m.method, {"embree", threads, m.settings}));
        } catch (const InputError& error) {
            if (left_out == nullptr) throw;
            left_out->push_back(m.name + ": " + error.what());
            continue;
        }
        results.push_back({.name = m.name, .ms = {}, .contacts = 0, .accuracy = {}});
        counts.emplace_back(recording, m.method == Method::rays);
    }
    Progress progress(what, recording.frame_count);
    auto next = truth.begin();
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        const bool known = next != truth.end() && next->frame == f;
        for (std::size_t m = 0; m < results.size(); ++m) {
            scenes::put_frame(*detectors[m], recording, f);
            const scenes::FrameResult result = detectors[m]->detect();
            results[m].ms.push_back(result.total_ms);
            results[m].contacts += static_cast<double>(result.contacts) / recording.frame_count;
            if (known) counts[m].add(*next, detectors[m]->contacts());
        }
        if (known) ++next;
        progress.show(f + 1);
    }
    for (std::size_t m = 0; m < results.size(); ++m) results[m].accuracy = counts[m].accuracy();
    return results;
}

namespace {

double median_of(std::vector<double> values) { return spread_of(std::move(values)).median; }
double p95_of(std::vector<double> values) { return spread_of(std::move(values)).p95; }
double degrees(double radians) { return radians * 180 / std::numbers::pi; }

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
        {"depth_ratio", {{"median", median_of(a.depth_ratios)}, {"p95", p95_of(a.depth_ratios)}}},
        {"normal_error_degrees",
         {{"median", degrees(median_of(a.normal_errors))},
          {"p95", degrees(p95_of(a.normal_errors))}}},
        {"pair_depth_ratio", a.pair_depth_ratio()}};
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
                                  : fmt::format("{:.3f}, {:.2f}", scale * median_of(values),
                                                scale * p95_of(values));
        };
        fmt::print("  {:<13}{:>9.3f}{:>17}{:>8}{:>10.3f}%{:>10.3f}%{:>16}{:>18}{:>12.3f}\n", c.name,
                   c.median_ms(), fmt::format("{} of {}", a.missed_pairs, a.pairs), a.false_pairs,
                   100 * a.missed_vertex_share(), 100 * a.missed_share(), two(a.depth_ratios, 1),
                   two(a.normal_errors, 180 / std::numbers::pi), a.pair_depth_ratio());
    }
}

}  // namespace

void add_convex_pieces(scenes::SceneSetup& scene) {
    for (scenes::SceneMesh& mesh : scene.meshes)
        for (const scenes::SceneInfo& info : scenes::scene_list()) {
            if (!mesh.convex_pieces.empty() || (mesh.name != "torus" && mesh.name != "bunny"))
                continue;
            if ((mesh.name == "torus") != (info.name == "tori")) continue;
            for (scenes::SceneMesh& known : scenes::make_scene(info.name, {1, false, 1}).meshes)
                if (known.name == mesh.name && known.data.positions == mesh.data.positions)
                    mesh.convex_pieces = std::move(known.convex_pieces);
        }
}

int compare_recording(const CompareOptions& options) {
    const scenes::Recording recording = scenes::read_recording(options.folder);
    std::vector<ComparedMethod> methods;
    methods.reserve(options.methods.size());
    for (const std::string& name : options.methods) methods.push_back(compared_method_named(name));
    if (methods.empty()) methods.assign(compared_methods().begin(), compared_methods().end());
    check_writable(options.json);
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
    if (!options.plots.empty()) {
        fs::create_directories(options.plots);
        write_plot(speed_against_error(results, options.folder.filename().string()), options.plots,
                   "f1_speed_against_error");
    }
    if (!options.json.empty()) {
        json list = json::array();
        for (const Comparison& c : results) list.push_back(to_json(c));
        write_json_file(
            options.json,
            {{"machine", machine_json()},
             {"versions", versions_json()},
             {"settings",
              {{"folder", options.folder.filename().string()}, {"threads", options.threads}}},
             {"methods", list}});
    }
    return 0;
}

Scatter speed_against_error(std::span<const Comparison> results, const std::string& scene) {
    Scatter plot{.title = "Speed against error, " + scene,
                 .x = "median time per frame [ms]",
                 .y = "depth-weighted miss rate",
                 .columns = {},
                 .points = {}};
    plot.columns = {"ms",
                    "missed_depth_share",
                    "missed_pair_depth_share",
                    "pairs",
                    "missed_pairs",
                    "false_pairs",
                    "missed_vertices_share",
                    "depth_ratio_median",
                    "depth_ratio_p95",
                    "normal_error_degrees_median",
                    "normal_error_degrees_p95",
                    "pair_depth_ratio"};
    for (const Comparison& c : results) {
        const Accuracy& a = c.accuracy;
        plot.points.push_back(
            {c.name,
             {c.median_ms(), a.missed_share(), a.missed_pair_share(), static_cast<double>(a.pairs),
              static_cast<double>(a.missed_pairs), static_cast<double>(a.false_pairs),
              a.missed_vertex_share(), median_of(a.depth_ratios), p95_of(a.depth_ratios),
              degrees(median_of(a.normal_errors)), degrees(p95_of(a.normal_errors)),
              a.pair_depth_ratio()}});
    }
    return plot;
}

}  // namespace pierce::app
