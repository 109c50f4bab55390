#include "app/reports/cloth/cloth_figures.hpp"

#include <algorithm>
#include <array>
#include <memory>

#include "app/measure/truth_program.hpp"
#include "app/output/frame_log.hpp"
#include "app/output/progress.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/measure/sheet_accuracy.hpp"
#include "scenes/simulate/crossing_motion.hpp"
#include "scenes/simulate/simulation.hpp"

namespace pierce::app {
namespace {

using scenes::SheetAccuracy;
using scenes::SheetPairs;

/// A way of looking for a sheet in itself, by the name it has in the report.
struct SheetMethod {
    std::string name;
    SelfCollision how = SelfCollision::on;
    double ray_length = 1;  ///< of rays [way of the vertex in the step]
    scenes::Method method = scenes::Method::rays;

    /// True if its contacts name vertices and triangles, or edges.
    bool names_features() const { return method == scenes::Method::rays; }
};

const std::array sheet_methods = {SheetMethod{"continuous", SelfCollision::on},
                                  SheetMethod{"rays", SelfCollision::rays},
                                  SheetMethod{"published", SelfCollision::published},
                                  SheetMethod{.name = "bullet-clusters",
                                              .how = SelfCollision::off,
                                              .ray_length = 1,
                                              .method = scenes::Method::bullet_clusters}};

/// What came of a method on a motion.
struct SheetComparison {
    SheetMethod method;
    std::vector<double> ms;  ///< per frame, the whole step
    SheetAccuracy self, others;
    /// Steps in which a sheet meets itself, and those of them in which it has no contact with
    /// itself at all.
    std::uint32_t steps = 0, missed_steps = 0;
};

scenes::SceneSetup scene_with(const scenes::Recording& recording, SelfCollision how) {
    scenes::SceneSetup scene = scenes::scene_of(recording);
    for (scenes::SceneBody& body : scene.bodies)
        if (body.collision.sheet) body.collision.self = how;
    return scene;
}

/// Puts all bodies where they are in a frame. Rays are as long as the way a vertex has come: of
/// longer ones, sheets are said to have come from further away.
void put(scenes::Detector& detector, const scenes::Recording& recording, std::uint32_t frame,
         double ray_length) {
    scenes::put_frame(detector, recording, frame);
    if (frame == 0 || ray_length == 1) return;
    std::vector<Vec3f> start;
    for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
        if (!recording.bodies[b].collision.sheet) continue;
        const std::span<const Vec3f> before = recording.positions(b, frame - 1),
                                     now = recording.positions(b, frame);
        start.clear();
        for (std::size_t v = 0; v < now.size(); ++v)
            start.push_back(to_float(to_double(now[v]) -
                                     ray_length * (to_double(now[v]) - to_double(before[v]))));
        // A World gives out handles in order, and a scene never removes a body.
        detector.world()->set_motion({b, 1}, start, now);
    }
}

/// Methods take turns frame by frame.
std::vector<SheetComparison> compare_sheets(const std::string& name,
                                            const scenes::Recording& recording,
                                            std::span<const scenes::TrueSheetFrame> truth,
                                            std::span<const SheetMethod> methods, int threads) {
    const scenes::SheetJudge judge(recording);
    std::vector<SheetComparison> results;
    std::vector<std::unique_ptr<scenes::Detector>> detectors;
    for (const SheetMethod& method : methods) {
        results.push_back(
            {.method = method, .ms = {}, .self = {}, .others = {}, .steps = 0, .missed_steps = 0});
        detectors.push_back(scenes::make_detector(scene_with(recording, method.how), method.method,
                                                  {"embree", threads, {}}));
    }
    Progress progress("comparing " + name, recording.frame_count);
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        for (std::size_t m = 0; m < results.size(); ++m) {
            put(*detectors[m], recording, f, methods[m].ray_length);
            const scenes::FrameResult result = detectors[m]->detect();
            if (f == 0) continue;
            results[m].ms.push_back(result.total_ms);
            if (std::ranges::any_of(truth[f].meetings, &scenes::FeatureMeeting::is_self)) {
                ++results[m].steps;
                results[m].missed_steps += std::ranges::none_of(
                    result.touching, [](const auto& pair) { return pair.first == pair.second; });
            }
            if (!methods[m].names_features()) continue;
            const std::span<const Contact> contacts = detectors[m]->world()->contacts();
            results[m].self += judge.judge(truth[f], contacts, SheetPairs::self);
            results[m].others += judge.judge(truth[f], contacts, SheetPairs::others);
        }
        progress.show(f + 1);
    }
    return results;
}

std::uint32_t triangle_count(const scenes::Recording& recording) {
    std::size_t count = 0;
    for (const scenes::RecordedBody& body : recording.bodies)
        if (body.collision.sheet) count += recording.meshes[body.mesh].data.triangles.size();
    return static_cast<std::uint32_t>(count);
}

constexpr const char* table_head =
    "| method | ms a frame: median, p95 | missed, of vertices and triangles that meet | missed, of "
    "edges that meet | "
    "recall | vertices without a contact, of those that go through a triangle | steps without a "
    "contact, of those with a "
    "meeting | reported crossings | of these near | of these wrong | precision "
    "|\n|---|---|---|---|---|---|---|---|---|---|---|";

void row(Page& page, const std::string& name, const SheetComparison& c, SheetPairs pairs) {
    const Spread ms = spread_of(c.ms);
    const SheetAccuracy& a = pairs == SheetPairs::self ? c.self : c.others;
    const std::string steps = pairs == SheetPairs::self
                                  ? fmt::format("{} of {}", c.missed_steps, c.steps)
                                  : "-";
    if (!c.method.names_features()) {
        page.line("| {} | {:.2f}, {:.2f} | - | - | - | - | {} | - | - | - | - |", name, ms.median,
                  ms.p95, steps);
        return;
    }
    page.line(
        "| {} | {:.2f}, {:.2f} | {} of {} | {} of {} | {:.4f} | {} of {} | {} | {} | {} | {} | "
        "{:.4f} |",
        name, ms.median, ms.p95, a.missed_vertex_meetings, a.vertex_meetings,
        a.missed_edge_meetings, a.edge_meetings, a.recall(), a.missed_vertices, a.vertices, steps,
        a.crossings, a.near, a.wrong, a.precision());
}

/// Recall and precision of rays over their length.
void ray_length_figure(const std::string& name, const scenes::Recording& recording,
                       std::span<const scenes::TrueSheetFrame> truth, int threads, Page& page) {
    std::vector<SheetMethod> methods;
    for (const double length : {0.25, 0.5, 1.0, 2.0, 4.0}) {
        methods.push_back({"rays", SelfCollision::rays, length});
        methods.push_back({"published", SelfCollision::published, length});
    }
    const std::vector<SheetComparison> results = compare_sheets(name, recording, truth, methods,
                                                                threads);
    Curves curves{
        .title = "Rays of Algorithm 1, " + name,
        .x = "length of the rays [way of the vertex in the step]",
        .y = {"share of vertices, share of crossings [1]"},
        .table = {{"length", "rays found", "rays right", "published found", "published right"}, {}},
        .log_x = true,
        .lines = {{.look = "rays", .note = "found"},
                  {.look = "rays", .note = "right", .stroke = Stroke::dashed},
                  {.look = "published", .note = "found"},
                  {.look = "published", .note = "right", .stroke = Stroke::dashed}}};
    for (std::size_t m = 0; m < results.size(); m += 2) {
        std::vector<double> values{results[m].method.ray_length};
        for (const SheetAccuracy& a : {results[m].self, results[m + 1].self}) {
            const double missed = static_cast<double>(a.missed_vertices),
                         all = static_cast<double>(a.vertices);
            values.push_back(all > 0 ? 1 - missed / all : 1);
            values.push_back(a.precision());
        }
        curves.table.rows.push_back(std::move(values));
    }
    page.plot(curves, "f8_ray_length_" + name);
}

}  // namespace

void cloth_accuracy_figure(const ClothReportOptions& options, Page& page) {
    page.line("## Missed and invented crossings\n");
    page.line(
        "Motions without self-contact, {:g} s at {:g} s a step. What meets in a step is decided "
        "exactly, for all vertices "
        "and "
        "triangles and all edges. *Near* is what does not meet, but comes within half a float32 "
        "ulp of it.\n",
        options.timing.seconds, options.timing.dt);
    for (const std::string& name : scenes::crossing_motion_names()) {
        const scenes::Recording recording = scenes::crossing_motion(
            name, {options.timing.seconds, options.timing.dt, options.nodes, options.seed});
        const std::vector<scenes::TrueSheetFrame> truth = sheet_truth_of(recording);
        std::size_t pierced = 0;
        double deepest = 0;
        for (const scenes::TrueSheetFrame& frame : truth) {
            pierced += frame.piercings.size();
            deepest = std::max(deepest, frame.self_penetration());
        }
        const std::vector<SheetComparison> results = compare_sheets(name, recording, truth,
                                                                    sheet_methods, options.threads);
        page.line("### {}\n", name);
        page.line(
            "{} triangles, {} frames; edges through triangles, all frames: {}; the deepest through "
            "itself: {:.4g}.\n",
            triangle_count(recording), recording.frame_count, pierced, deepest);
        const bool meets_itself = results[0].steps > 0;
        if (!meets_itself && results[0].others.meetings() == 0) {
            page.line("Nothing meets in this time, so there is nothing to find.\n");
            continue;
        }
        page.line("{}", table_head);
        for (const SheetComparison& c : results)
            if (meets_itself) row(page, c.method.name, c, SheetPairs::self);
        if (results[0].others.meetings() > 0)
            row(page, "continuous, with other bodies", results[0], SheetPairs::others);
        page.line("");
        if (meets_itself) ray_length_figure(name, recording, truth, options.threads, page);
    }
}

namespace {

/// Cloth on the capsule that a method's own contacts keep apart.
struct Fall {
    scenes::Recording recording;
    FrameLog log;
    std::vector<double> exact;  ///< per frame, how deep it truly goes through itself
};

Fall fall(const SheetMethod& method, const ClothReportOptions& options) {
    scenes::SceneSetup scene = scenes::make_scene("cloth-capsule",
                                                  {.seed = options.seed, .nodes = options.nodes});
    for (scenes::SceneBody& body : scene.bodies)
        if (body.collision.sheet) body.collision.self = method.how;
    scenes::Simulation simulation(scene, method.method, {"embree", options.threads, {}});
    Fall result{scenes::start_recording(scene, options.falling.dt), {}, {}};
    Progress progress("falling", options.falling.steps());
    for (std::uint32_t i = 0; i < options.falling.steps(); ++i) {
        result.log.add(simulation.step(options.falling.dt));
        simulation.record(result.recording);
        progress.show(i + 1);
    }
    for (scenes::RecordedBody& body : result.recording.bodies)
        if (body.collision.sheet) body.collision.self = SelfCollision::on;
    for (const scenes::TrueSheetFrame& frame : sheet_truth_of(result.recording))
        result.exact.push_back(frame.self_penetration());
    return result;
}

}  // namespace

void cloth_penetration_figure(const ClothReportOptions& options, Page& page) {
    page.line("## Figure 16: how deep cloth goes through itself\n");
    page.line(
        "A sheet falls on a capsule, on the ground and on itself for {:g} s at {:g} s a step, kept "
        "off itself by each "
        "method's contacts. Depth is that of edges through triangles, decided exactly: of the "
        "edge's two ends, the smaller "
        "distance to the triangle's plane.\n",
        options.falling.seconds, options.falling.dt);
    Curves curves{.title = "Deepest of the cloth through itself",
                  .x = "time [s]",
                  .y = {"depth [m]"},
                  .table = {{"time", "paper"}, {}},
                  .log_x = false,
                  .log_y = true,
                  .lines = {{.look = "paper", .stroke = Stroke::dashed}}};
    for (std::uint32_t i = 0; i < options.falling.steps(); ++i)
        curves.table.rows.push_back({(i + 1) * options.falling.dt, paper_penetration});
    page.line(
        "| contacts | deepest, exact | over the paper's {:g} | frames with any | last frame | "
        "summary.self_penetration_max "
        "| "
        "ms a step: median, p95 |\n|---|---|---|---|---|---|---|",
        paper_penetration);
    for (const SheetMethod& method : sheet_methods) {
        const Fall result = fall(method, options);
        curves.table.names.push_back(method.name);
        curves.lines.push_back({.look = method.name});
        for (std::size_t i = 0; i < result.exact.size(); ++i)
            curves.table.rows[i].push_back(result.exact[i]);
        const double deepest = std::ranges::max(result.exact);
        const auto any = std::ranges::count_if(result.exact, [](double d) { return d > 0; });
        const Spread ms = spread_of(result.log.column(&scenes::FrameResult::total_ms));
        page.line("| {} | {:.5g} | {:.3g} | {} of {} | {:.5g} | {:.5g} | {:.2f}, {:.2f} |",
                  method.name, deepest, deepest / paper_penetration, any, result.exact.size(),
                  result.exact.back(),
                  spread_of(result.log.column(&scenes::FrameResult::self_penetration)).max,
                  ms.median, ms.p95);
    }
    page.plot(curves, "figure_16");
}

}  // namespace pierce::app
