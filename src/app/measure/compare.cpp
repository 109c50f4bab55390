#include "app/measure/compare.hpp"

#include <cmath>
#include <numbers>
#include <optional>

#include "app/output/frame_log.hpp"
#include "app/output/progress.hpp"
#include "app/output/waiting.hpp"
#include "pierce/error.hpp"
#include "scenes/detect/detector.hpp"

namespace pierce::app {

using scenes::Accuracy;
using scenes::Method;

namespace {

Settings vertices(Temporal temporal, bool predict = true) {
    Settings settings = vertex_rays;
    settings.temporal = temporal;
    settings.predict = predict;
    return settings;
}

}  // namespace

std::span<const ComparedMethod> compared_methods() {
    static const std::vector<ComparedMethod> methods{
        {"full", Method::rays, vertices(Temporal::off)},
        {"walk", Method::rays, vertices(Temporal::paper, false)},
        {"walk-predict", Method::rays, vertices(Temporal::paper)},
        {"certified", Method::rays, vertices(Temporal::certified)},
        {"overlaps", Method::rays, {.coverage = Coverage::overlaps, .reproject = true}},
        {"complete", Method::rays, {.coverage = Coverage::complete, .reproject = false}},
        {"reprojected", Method::rays, {.coverage = Coverage::complete, .reproject = true}},
        {"gjk-hull", Method::gjk_hull, {}},
        {"gjk-epa", Method::gjk_epa, {}},
        {"gimpact", Method::gimpact, {}},
        {"fcl", Method::fcl, {}}};
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
    std::optional<Waiting> making(what + ": making meshes");
    std::vector<std::unique_ptr<scenes::Detector>> detectors;
    std::vector<scenes::AccuracyCount> counts;
    for (const ComparedMethod& m : methods) {
        try {
            if (m.method != Method::rays) scenes::require_lasting_meshes(recording, m.name);
            detectors.push_back(
                scenes::make_detector(scene, m.method, {"embree", threads, m.settings}));
        } catch (const InputError& error) {
            if (left_out == nullptr) throw;
            left_out->push_back(m.name + ": " + error.what());
            continue;
        }
        results.push_back(
            {.name = m.name, .ms = {}, .missed_shares = {}, .contacts = 0, .accuracy = {}});
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
            const Accuracy& sum = counts[m].accuracy();
            const double depth = sum.depth, missed = sum.missed_depth;
            if (known) counts[m].add(*next, detectors[m]->contacts());
            const double frame_depth = sum.depth - depth, frame_missed = sum.missed_depth - missed;
            results[m].missed_shares.push_back(!known            ? std::nan("")
                                               : frame_depth > 0 ? frame_missed / frame_depth
                                                                 : 0);
        }
        if (known) ++next;
        making.reset();
        progress.show(f + 1);
    }
    for (std::size_t m = 0; m < results.size(); ++m) results[m].accuracy = counts[m].accuracy();
    return results;
}

namespace {

double median_of(std::vector<double> values) { return spread_of(std::move(values)).median; }
double p95_of(std::vector<double> values) { return spread_of(std::move(values)).p95; }

}  // namespace

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

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

Table figures_of(std::span<const Comparison> results) {
    Table table;
    table.label_name = points_label;
    table.names = {"ms",
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
        table.labels.push_back(c.name);
        table.rows.push_back({c.median_ms(), a.missed_share(), a.missed_pair_share(),
                              static_cast<double>(a.pairs), static_cast<double>(a.missed_pairs),
                              static_cast<double>(a.false_pairs), a.missed_vertex_share(),
                              median_of(a.depth_ratios), p95_of(a.depth_ratios),
                              degrees(median_of(a.normal_errors)), degrees(p95_of(a.normal_errors)),
                              a.pair_depth_ratio()});
    }
    return table;
}

}  // namespace pierce::app
