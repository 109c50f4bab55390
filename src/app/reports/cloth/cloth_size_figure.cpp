#include "app/reports/cloth/cloth_size_figure.hpp"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "app/measure/truth_program.hpp"
#include "app/output/frame_log.hpp"
#include "app/output/json_file.hpp"
#include "app/output/progress.hpp"
#include "app/output/provenance.hpp"
#include "app/output/waiting.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/measure/sheet_accuracy.hpp"
#include "scenes/named/layers.hpp"
#include "scenes/simulate/simulation.hpp"

namespace pierce::app {
namespace {

using nlohmann::json;
using scenes::Method;
using scenes::Recording;
using scenes::SheetAccuracy;
using scenes::SheetPairs;

/// Steps that are timed, evenly over a motion.
constexpr std::uint32_t timed_steps = 120;
/// The exact truth is made of as many of these as this allows [vertices, over all steps], and of
/// one at least.
constexpr std::size_t truth_vertices = 200'000;
/// Bullet makes its clusters in a time that grows with the square of a sheet's vertices: beyond
/// this, minutes.
constexpr std::size_t most_cluster_nodes = 20'000;
/// Of the layers [s].
constexpr double layers_seconds = 0.5;

/// Some steps of a motion: where they begin, and where they end.
struct Steps {
    Recording starts, ends;
};

/// A motion, at some of its steps.
struct Motion {
    std::string name;
    std::uint32_t nodes = 0;
    double dt = 0, seconds = 0;
    Steps tried, kept;  ///< ends where Bullet has put the sheet; and where contacts have. `tried`
                        ///< may be empty.
    double self_penetration = 0;  ///< the deepest, over all steps
    std::uint32_t pulled_back = 0, all_steps = 0;
    std::vector<double> simulation_ms;  ///< per step, what keeping the sheet apart took
};

std::uint32_t stride_of(std::uint32_t steps) { return std::max(1u, steps / timed_steps); }

Motion capsule_motion(std::uint32_t nodes, const ClothReportOptions& options) {
    const scenes::SceneSetup scene = scenes::make_scene("cloth-capsule",
                                                        {.seed = options.seed, .nodes = nodes});
    scenes::Simulation simulation(scene, Method::rays, {"embree", options.threads, {}});
    Motion motion{.name = "cloth-capsule",
                  .nodes = nodes,
                  .dt = scene.dt,
                  .seconds = options.size_seconds,
                  .tried = {},
                  .kept = {},
                  .self_penetration = 0,
                  .pulled_back = 0,
                  .all_steps = 0,
                  .simulation_ms = {}};
    for (Recording* r : {&motion.tried.starts, &motion.tried.ends, &motion.kept.ends})
        *r = scenes::start_recording(scene, scene.dt);
    motion.all_steps = Timing{options.size_seconds, scene.dt}.steps();
    Progress progress(fmt::format("falling, {} x {}", nodes, nodes), motion.all_steps);
    for (std::uint32_t i = 0; i < motion.all_steps; ++i) {
        const bool timed = i % stride_of(motion.all_steps) == 0;
        if (timed) simulation.record(motion.tried.starts);
        const scenes::FrameResult& result = simulation.step(scene.dt);
        motion.self_penetration = std::max(motion.self_penetration, result.self_penetration);
        motion.pulled_back += result.pulled_back;
        motion.simulation_ms.push_back(result.total_ms);
        if (timed) {
            simulation.record_tried(motion.tried.ends);
            simulation.record(motion.kept.ends);
        }
        progress.show(i + 1);
    }
    motion.kept.starts = motion.tried.starts;
    return motion;
}

Motion layers_motion(std::uint32_t nodes) {
    const Waiting waiting("making layers");
    const scenes::Layers layers = scenes::layers_with(nodes);
    const scenes::SceneSetup scene = layers.scene();
    Motion motion{.name = "layers",
                  .nodes = layers.across,
                  .dt = scene.dt,
                  .seconds = layers_seconds,
                  .tried = {},
                  .kept = {},
                  .self_penetration = 0,
                  .pulled_back = 0,
                  .all_steps = 0,
                  .simulation_ms = {}};
    motion.all_steps = Timing{layers_seconds, scene.dt}.steps();
    std::vector<Vec3f> at(layers.vertex_count());
    for (const std::uint32_t later : {0u, 1u}) {
        Recording& frames = later == 0 ? motion.kept.starts : motion.kept.ends;
        frames = scenes::start_recording(scene, scene.dt);
        for (std::uint32_t f = 0; f < motion.all_steps; ++f)
            for (std::uint32_t b = 0; b < layers.sheets; ++b) {
                layers.positions(b, (f + later) * scene.dt, at);
                for (Vec3f p : at)
                    frames.bodies[b].values.insert(frames.bodies[b].values.end(), {p.x, p.y, p.z});
            }
        frames.frame_count = motion.all_steps;
    }
    return motion;
}

void append_frame(const Recording& from, std::uint32_t frame, Recording& to) {
    for (std::size_t b = 0; b < from.bodies.size(); ++b) {
        const std::vector<float>& values = from.bodies[b].values;
        const auto size = static_cast<std::ptrdiff_t>(values.size() / from.frame_count);
        const auto begin = values.begin() + size * static_cast<std::ptrdiff_t>(frame);
        to.bodies[b].values.insert(to.bodies[b].values.end(), begin, begin + size);
    }
    ++to.frame_count;
}

/// Every `stride`th step, as frames from 1 on: where it begins, where it ends, where the next one
/// begins, and so on.
Recording interleaved(const Steps& steps, std::uint32_t stride) {
    Recording result = steps.starts;
    for (scenes::RecordedBody& body : result.bodies) body.values.clear();
    result.frame_count = 0;
    append_frame(steps.starts, 0, result);
    for (std::uint32_t s = stride - 1; s < steps.ends.frame_count; s += stride) {
        append_frame(steps.starts, s, result);
        append_frame(steps.ends, s, result);
    }
    return result;
}

std::size_t sheet_vertices(const Recording& recording, bool largest) {
    std::size_t all = 0, most = 0;
    for (const scenes::RecordedBody& body : recording.bodies) {
        if (!body.collision.sheet) continue;
        const std::size_t count = recording.meshes[body.mesh].data.positions.size();
        all += count;
        most = std::max(most, count);
    }
    return largest ? most : all;
}

/// What a way of looking found, on some steps of a motion.
struct Row {
    std::string scene, ends, method;
    std::uint32_t nodes = 0;
    int threads = 0;
    std::size_t triangles = 0;
    std::vector<double> ms, contacts, crossings;
    std::uint32_t truth_steps = 0;
    double exact_self_penetration = 0;  ///< the deepest, at the ends of these
    SheetAccuracy accuracy;
};

struct Looked {
    std::unique_ptr<scenes::Detector> detector;
    Row row;
};

/// Puts all bodies at a step's end, having come from its start.
void put(scenes::Detector& detector, const Steps& steps, std::uint32_t step) {
    scenes::put_frame(detector, steps.ends, step);
    World* world = detector.world();
    if (world == nullptr) return;
    // A World gives out handles in order, and a scene never removes a body.
    for (std::uint32_t b = 0; b < steps.ends.bodies.size(); ++b)
        if (steps.ends.bodies[b].motion == pierce::Motion::deforming)
            world->set_motion({b, 1}, steps.starts.positions(b, step),
                              steps.ends.positions(b, step));
    world->forget_sides();
}

/// Ways of looking take turns step by step.
std::vector<Row> look(const Motion& motion, const Steps& steps, const std::string& ends,
                      int threads) {
    const std::size_t vertices = sheet_vertices(steps.ends, false);
    const auto truths = std::clamp<std::size_t>(truth_vertices / vertices, 1,
                                                steps.ends.frame_count);
    const auto stride = static_cast<std::uint32_t>(steps.ends.frame_count / truths);
    const Recording judged = interleaved(steps, stride);
    const std::vector<scenes::TrueSheetFrame> truth = sheet_truth_of(judged, 2);
    const scenes::SheetJudge judge(judged);

    scenes::SceneSetup scene = scenes::scene_of(steps.ends);
    std::vector<Looked> all;
    std::size_t triangles = 0;
    for (const scenes::RecordedBody& body : steps.ends.bodies)
        if (body.collision.sheet) triangles += steps.ends.meshes[body.mesh].data.triangles.size();
    const auto add = [&](const char* name, Method method, int count) {
        all.push_back({scenes::make_detector(scene, method, {"embree", count, {}}), {}});
        Row& row = all.back().row;
        row = {.scene = motion.name,
               .ends = ends,
               .method = name,
               .nodes = motion.nodes,
               .threads = count,
               .triangles = triangles,
               .ms = {},
               .contacts = {},
               .crossings = {},
               .truth_steps = 0,
               .exact_self_penetration = 0,
               .accuracy = {}};
    };
    for (const int count : std::set<int>{1, threads}) add("continuous", Method::rays, count);
    if (sheet_vertices(steps.ends, true) <= most_cluster_nodes)
        add("bullet-clusters", Method::bullet_clusters, 1);

    Progress progress(fmt::format("looking at {} {}, {}", motion.name, motion.nodes, ends),
                      steps.ends.frame_count);
    for (std::uint32_t s = 0; s < steps.ends.frame_count; ++s) {
        const bool known = (s + 1) % stride == 0;
        for (Looked& l : all) {
            put(*l.detector, steps, s);
            const scenes::FrameResult result = l.detector->detect();
            l.row.ms.push_back(result.total_ms);
            l.row.contacts.push_back(result.contacts);
            l.row.crossings.push_back(result.crossings);
            if (!known) continue;
            ++l.row.truth_steps;
            l.row.exact_self_penetration = std::max(l.row.exact_self_penetration,
                                                    truth[(s + 1) / stride].self_penetration());
            if (l.detector->world() == nullptr) continue;
            for (const SheetPairs pairs : {SheetPairs::self, SheetPairs::others})
                l.row.accuracy += judge.judge(truth[(s + 1) / stride],
                                              l.detector->world()->contacts(), pairs);
        }
        progress.show(s + 1);
    }
    std::vector<Row> rows;
    rows.reserve(all.size());
    for (Looked& l : all) rows.push_back(std::move(l.row));
    return rows;
}

json row_json(const Row& r, const Motion& motion) {
    const Spread ms = spread_of(r.ms);
    json result{{"scene", r.scene},
                {"nodes", r.nodes},
                {"triangles", r.triangles},
                {"ends", r.ends},
                {"method", r.method},
                {"threads", r.threads},
                {"dt", motion.dt},
                {"seconds", motion.seconds},
                {"simulated_steps", motion.all_steps},
                {"timed_steps", r.ms.size()},
                {"ms_median", ms.median},
                {"ms_p95", ms.p95},
                {"contacts_median", spread_of(r.contacts).median},
                {"truth_steps", r.truth_steps},
                {"exact_self_penetration", r.exact_self_penetration}};
    if (!motion.simulation_ms.empty())
        result.update({{"self_penetration_max", motion.self_penetration},
                       {"pulled_back", motion.pulled_back},
                       {"step_ms", spread_of(motion.simulation_ms).median},
                       {"step_ms_p95", spread_of(motion.simulation_ms).p95}});
    // Clusters name no vertex and no triangle.
    if (r.method == "bullet-clusters") return result;
    const SheetAccuracy& a = r.accuracy;
    result.update({{"meet", a.meetings()},
                   {"missed", a.missed()},
                   {"reported", a.crossings},
                   {"near", a.near},
                   {"wrong", a.wrong},
                   {"recall", a.recall()},
                   {"precision", a.precision()}});
    return result;
}

void print_row(const json& r, Page& page) {
    const auto count = [&](const char* key) {
        return r.contains(key) ? std::to_string(r[key].get<std::uint64_t>()) : "-";
    };
    const auto share = [&](const char* key, const char* of) {
        return r.contains(of) && r[of] != 0 ? fmt::format("{:.4f}", r[key].get<double>()) : "-";
    };
    page.line(
        "| {} {} | {} | {} | {} | {} | {:.2f}, {:.2f} | {:.0f} | {} | {:.4g} | {} of {} | {} | {} "
        "of {} | {} |",
        r["scene"].get<std::string>(), count("nodes"), count("triangles"),
        r["ends"].get<std::string>(), r["method"].get<std::string>(), count("threads"),
        r["ms_median"].get<double>(), r["ms_p95"].get<double>(), r["contacts_median"].get<double>(),
        count("truth_steps"), r["exact_self_penetration"].get<double>(), count("missed"),
        count("meet"), share("recall", "meet"), count("wrong"), count("reported"),
        share("precision", "reported"));
}

}  // namespace

void cloth_size_figure(const ClothReportOptions& options, Page& page) {
    page.line("## Time and error as sheets get finer\n");
    page.line(
        "Sheets that fall on the capsule for {:g} s and are kept off themselves, and layers that "
        "never meet. At most {} of "
        "the steps, evenly over the motion, are looked at again, each from where it began, by all "
        "methods in turn; the "
        "exact "
        "truth is made of as many of these as have {} vertices together. *Tried* steps end where "
        "Bullet has put the sheet, "
        "*kept* ones where its contacts have. Missed, wrong: of crossings, with itself and with "
        "others. Bullet's clusters "
        "are "
        "looked for on one thread, whatever it is given, name nothing that could be judged, and "
        "are not made for sheets of "
        "more than {} vertices.\n",
        options.size_seconds, 2 * timed_steps, truth_vertices, most_cluster_nodes);
    json rows = json::array();
    std::vector<std::string> motions;
    page.line(
        "| scene | triangles | steps | method | threads | ms a detection: median, p95 | contacts | "
        "steps with truth | "
        "deepest through itself, exact | "
        "missed "
        "| recall | wrong | precision |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    const auto measure = [&](const Motion& motion) {
        for (const bool tried : {true, false}) {
            if (tried && motion.tried.ends.frame_count == 0) continue;
            for (const Row& row : look(motion, tried ? motion.tried : motion.kept,
                                       tried ? "tried" : "kept", options.threads)) {
                rows.push_back(row_json(row, motion));
                print_row(rows.back(), page);
            }
        }
        if (motion.simulation_ms.empty()) return;
        const Spread ms = spread_of(motion.simulation_ms);
        motions.push_back(fmt::format("| {} {} | {:.5g} | {} | {:.5g} | {} | {:.2f}, {:.2f} |",
                                      motion.name, motion.nodes, motion.dt, motion.all_steps,
                                      motion.self_penetration, motion.pulled_back, ms.median,
                                      ms.p95));
    };
    for (const std::uint32_t nodes : options.sizes) measure(capsule_motion(nodes, options));
    measure(layers_motion(options.layers_nodes));
    page.line(
        "\n| motion | s a step | steps | self_penetration_max | vertices pulled back | ms a step, "
        "all detections and "
        "response: median, p95 |\n|---|---|---|---|---|---|");
    for (const std::string& line : motions) page.line("{}", line);
    page.line("");
    write_json_file(options.out / "size.json",
                    {{"machine", machine_json()},
                     {"versions", versions_json()},
                     {"settings", {{"seed", options.seed}, {"threads", options.threads}}},
                     {"rows", rows}});
}

}  // namespace pierce::app
