#include "app/commands/commands.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/commands/detection_page.hpp"
#include "app/measure/compare.hpp"
#include "app/measure/recording_files.hpp"
#include "app/output/detection_json.hpp"
#include "app/output/frame_log.hpp"
#include "app/output/json_file.hpp"
#include "app/output/picture.hpp"
#include "app/output/progress.hpp"
#include "app/output/provenance.hpp"
#include "app/output/waiting.hpp"
#include "app/reports/paper/table_4.hpp"
#include "pierce/error.hpp"
#include "pierce/world.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/files/mesh_io.hpp"
#include "scenes/recording/recording.hpp"
#include "scenes/simulate/simulation.hpp"

namespace pierce::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using scenes::FrameResult;

constexpr std::uint32_t demo_stride = 4;  // GJK/EPA replays every fourth frame, to keep the demo
                                          // short

/// True for a frame whose times count; in the first one meshes are prepared.
bool is_compared(std::uint32_t frame) { return frame > 0 && frame % demo_stride == 0; }

json detection_json(const DetectionOptions& options) {
    json result = rays_json(options.rays);
    result["method"] = options.method;
    return result;
}

void write_last_picture(World& world, const scenes::SceneSetup& scene, const fs::path& file) {
    const std::vector<BodyId> ground = ground_of(scene);
    write_picture(world, ground, {.around = box_of_bodies(world, ground)}, file);
}

fs::path picture_of(const fs::path& folder, std::uint32_t frame) {
    return folder / fmt::format("{:05}.png", frame);
}

/// Those of another replay are not to follow this one's.
void remove_pictures(const fs::path& folder) {
    for (std::uint32_t f = 0; fs::remove(picture_of(folder, f)); ++f) {
    }
}

void require_rays(World* world, const fs::path& png) {
    if (world == nullptr && !png.empty())
        throw InputError("--png and --pictures need --method rays: they trace the pictures");
}

scenes::SceneSetup scene_of(const RunOptions& options) {
    scenes::SceneSetup scene = scenes::make_scene(
        options.scene, {options.count, options.soft, options.seed, options.nodes});
    // A recording keeps what was asked for.
    for (std::uint32_t m = 0; m < scene.meshes.size(); ++m) {
        const bool is_sheet = std::ranges::any_of(scene.bodies, [&](const scenes::SceneBody& b) {
            return b.mesh == m && b.collision.sheet;
        });
        if (!is_sheet && scene.meshes[m].inside == Inside::automatic)
            scene.meshes[m].inside = options.detection.rays.inside;
    }
    return scene;
}

bool has_own_size(const scenes::SceneSetup& scene) {
    return std::ranges::any_of(
        scene.bodies, [](const scenes::SceneBody& b) { return b.collision != Collision{}; });
}

std::uint32_t step_count(double seconds, double dt) {
    const double steps = std::round(seconds / dt);
    if (!(steps <= std::numeric_limits<std::uint32_t>::max()))
        throw InputError("too many time steps");
    return std::max(1u, static_cast<std::uint32_t>(steps));
}

/// Says, here and in what the files hold, that they hold some of the frames only.
void say_stopped(std::size_t done, std::uint32_t total, std::initializer_list<fs::path> files,
                 json& settings) {
    std::vector<std::string> written;
    for (const fs::path& file : files)
        if (!file.empty()) written.push_back(file.string());
    const std::string stop = fmt::format("after {} of {} frames", done, total);
    settings["stopped"] = stop;
    fmt::print(stderr, "pierce: stopped {}{}\n", stop,
               written.empty() ? std::string()
                               : fmt::format(": {} {} these frames only", fmt::join(written, ", "),
                                             written.size() == 1 ? "holds" : "hold"));
}

}  // namespace

int list_scenes() {
    for (const scenes::SceneInfo& info : scenes::scene_list())
        fmt::print("{:<13} {}\n", info.name, info.description);
    return 0;
}

int show_plan(const RunOptions& options) {
    const scenes::SceneSetup setup = scene_of(options);
    scenes::SceneWorld scene(setup, options.detection.rays);
    const Plan& plan = scene.world.plan();
    fmt::print("bodies    {} fixed, {} rigid, {} deforming; {} of them open\n", plan.fixed_bodies,
               plan.rigid_bodies, plan.deforming_bodies, plan.open_bodies);
    fmt::print("stages   ");
    for (StageId stage : plan.stages) fmt::print(" {}", name_of(stage));
    fmt::print("\nbounds    {}\n", plan.measures_deformation
                                       ? "poses of rigid bodies, vertices of deforming ones"
                                       : "poses only: no vertex is looked at");
    fmt::print("update    {}\n",
               plan.measures_deformation
                   ? "one static tree per mesh, one refitted tree per deforming body"
                   : "one static tree per mesh, built once");
    fmt::print("classify  {}\n",
               plan.settings.inside_is_contact() ? "every vertex inside is in contact"
               : plan.traces_own_exits
                   ? "own exits traced for contacts of deforming sources and of edges"
                   : "own exits looked up: they were traced once per mesh");
    fmt::print("remembers {}\n", !plan.remembers() ? "nothing: every step stands alone"
                                 : plan.settings.temporal == Temporal::paper
                                     ? "hits, and walks on from them between full passes"
                                     : "hits and proofs, and leaves out what they make needless");
    for (const PlannedPart& part : plan.parts)
        fmt::print("part      {}: {:g} of the work\n", part.backend, part.share);
    for (const std::string& note : plan.notes) fmt::print("note      {}\n", note);
    return 0;
}

int run(const RunOptions& options) {
    const scenes::SceneSetup scene = scene_of(options);
    const double dt = options.dt > 0 ? options.dt : scene.dt;
    scenes::Simulation simulation(scene, scenes::method_named(options.detection.method),
                                  options.detection.rays);
    require_rays(simulation.world(), options.png);
    check_folder_writable(options.record);
    check_writable(options.png);
    check_writable(options.detection.json);
    check_different({options.png, options.detection.json, options.detection.page.file});
    DetectionPage page(options.detection.page, simulation.world(), options.scene, names_of(scene),
                       dt);
    scenes::Recording recording = scenes::start_recording(scene, dt);

    FrameLog log;
    const std::uint32_t steps = step_count(options.seconds, dt);
    const InterruptDelay until_all_is_written;
    const auto stop = until_interrupted([&] {
        Progress progress("simulating", steps);
        for (std::uint32_t i = 0; i < steps; ++i) {
            log.add(options.record.empty() ? simulation.step(dt) : simulation.step(dt, recording));
            page.add(log.last_json());
            progress.show(i + 1);
        }
    });
    const std::string bodies = has_own_size(scene) ? fmt::format("{} bodies", scene.bodies.size())
                                                   : fmt::format("{} {} bodies", options.count,
                                                                 options.soft ? "soft" : "rigid");
    fmt::print("{}: {}, {} steps of {:.5g} s, method {}", options.scene, bodies, log.size(), dt,
               options.detection.method);
    fmt::print("{}\n", simulation.world() != nullptr ? ", " + simulation.world()->backend() : "");
    log.print();

    if (!options.record.empty()) save_recording(recording, options.record);
    if (!options.png.empty()) write_last_picture(*simulation.world(), scene, options.png);
    json settings = detection_json(options.detection);
    settings.update({{"command", "run"},
                     {"scene", options.scene},
                     {"count", options.count},
                     {"soft", options.soft},
                     {"seconds", options.seconds},
                     {"dt", dt},
                     {"seed", options.seed},
                     {"nodes", options.nodes}});
    if (stop)
        say_stopped(log.size(), steps,
                    {options.record, options.detection.json, options.detection.page.file},
                    settings);
    if (!options.detection.json.empty()) log.write_json(options.detection.json, settings);
    page.write(settings, {}, json::array());
    return 0;
}

int replay(const ReplayOptions& options) {
    scenes::Recording recording = load_recording(options.folder);
    if (options.deforming) {
        const Waiting waiting("giving motion vertex by vertex");
        recording = scenes::as_deforming(recording);
    }
    scenes::SceneSetup scene = scenes::scene_of(recording);
    const scenes::Method method = scenes::method_named(options.detection.method);
    if (method == scenes::Method::gjk_epa) add_convex_pieces(scene);
    const auto detector = scenes::make_detector(scene, method, options.detection.rays);
    require_rays(detector->world(), options.png);
    require_rays(detector->world(), options.pictures);
    check_writable(options.png);
    check_writable(options.detection.json);
    check_different({options.png, options.detection.json, options.detection.page.file});
    DetectionPage page(options.detection.page, detector->world(),
                       options.folder.filename().string(), names_of(scene), recording.dt);

    const std::vector<BodyId> ground = ground_of(scene);
    Shot shot;
    if (!options.pictures.empty() && recording.frame_count > 0) {
        // All pictures show the place where the bodies end, which a world of its own finds out.
        fs::create_directories(options.pictures);
        remove_pictures(options.pictures);
        const auto ahead = scenes::make_detector(scene, method, options.detection.rays);
        scenes::put_frame(*ahead, recording, recording.frame_count - 1);
        shot.deepest = ahead->detect().penetration_max;
        shot.around = box_of_bodies(*ahead->world(), ground);
        shot.contacts = true;
    }
    FrameLog log;
    const InterruptDelay until_all_is_written;
    const auto stop = until_interrupted([&] {
        Progress progress("replaying", recording.frame_count);
        for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
            scenes::put_frame(*detector, recording, f);
            log.add(detector->detect());
            page.add(log.last_json());
            if (!options.pictures.empty())
                write_picture(*detector->world(), ground, shot, picture_of(options.pictures, f));
            progress.show(f + 1);
        }
    });
    fmt::print("{}: {} bodies, {} frames, method {}", options.folder.string(),
               recording.bodies.size(), log.size(), options.detection.method);
    fmt::print("{}\n", detector->world() != nullptr ? ", " + detector->world()->backend() : "");
    log.print();

    if (!options.png.empty()) write_last_picture(*detector->world(), scene, options.png);
    json settings = detection_json(options.detection);
    settings.update({{"command", "replay"},
                     {"folder", options.folder.filename().string()},
                     {"deforming", options.deforming},
                     {"dt", recording.dt}});
    if (stop)
        say_stopped(log.size(), recording.frame_count,
                    {options.pictures, options.detection.json, options.detection.page.file},
                    settings);
    if (!options.detection.json.empty()) log.write_json(options.detection.json, settings);
    page.write(settings, options.folder, json::array());
    return 0;
}

int detect(const DetectOptions& options) {
    scenes::SceneSetup setup;
    std::vector<std::string> names;
    for (const fs::path& file : options.meshes) {
        const Waiting waiting("reading " + file.string());
        names.push_back(file.string());
        scenes::SceneBody& body = setup.bodies.emplace_back();
        body.name = names.back();
        body.mesh = static_cast<std::uint32_t>(setup.meshes.size());
        setup.meshes.push_back(
            {.name = names.back(), .data = scenes::read_mesh(file), .convex_pieces = {}});
    }
    scenes::SceneWorld scene(setup, options.detection.rays);
    World& world = scene.world;
    check_writable(options.detection.json);
    check_different({options.detection.json, options.detection.page.file});
    DetectionPage page(options.detection.page, &world, fmt::format("{}", fmt::join(names, ", ")),
                       names, 0);
    for (const std::string& note : world.plan().notes) fmt::print("note: {}\n", note);
    const StepStats& stats = world.detect();

    json list = json::array();
    const auto contacts = world.contacts();
    for (std::size_t begin = 0, end = 0; begin < contacts.size(); begin = end) {
        double deepest = 0, sum = 0;
        for (; end < contacts.size() && contacts[end].a == contacts[begin].a &&
               contacts[end].b == contacts[begin].b;
             ++end) {
            deepest = std::max(deepest, contacts[end].penetration_depth());
            sum += contacts[end].penetration_depth();
        }
        fmt::print("{} and {}: {} contacts, depth mean {:.6g}, max {:.6g}\n",
                   names[contacts[begin].a.index], names[contacts[begin].b.index], end - begin,
                   sum / static_cast<double>(end - begin), deepest);
    }
    for (const Contact& c : contacts) list.push_back(contact_json(c));
    fmt::print("{} contacts in {} of {} overlapping pairs, {} rays, {:.3f} ms, {}\n",
               stats.contacts, stats.touching_pairs, stats.pairs, stats.rays, stats.milliseconds,
               world.backend());
    json settings = rays_json(options.detection.rays);
    settings.update({{"command", "detect"}, {"meshes", names}});
    if (!options.detection.json.empty())
        write_json_file(options.detection.json, {{"machine", machine_json()},
                                                 {"versions", versions_json()},
                                                 {"settings", settings},
                                                 {"bodies", names},
                                                 {"contacts", list}});
    FrameLog log;
    log.add(scene.result());
    page.add(log.last_json());
    page.write(settings, {}, json::array());
    return 0;
}

int demo(const fs::path& png, const fs::path& html) {
    const RunOptions options{.scene = "tori",
                             .count = 100,
                             .soft = false,
                             .seconds = 10,
                             .dt = 1.0 / 60,
                             .seed = 1,
                             .nodes = 0,
                             .record = {},
                             .png = png,
                             .detection = {}};
    check_writable(png);
    const scenes::SceneSetup scene = scene_of(options);
    scenes::Simulation simulation(scene, scenes::Method::rays, options.detection.rays);
    scenes::Recording recording = scenes::start_recording(scene, options.dt);
    const std::uint32_t steps = step_count(options.seconds, options.dt);
    // The page is made from the same motion once more, so that its work slows no step.
    scenes::Simulation shown(scene, scenes::Method::rays, options.detection.rays);
    DetectionPage page({.file = html}, shown.world(), "100 tori", names_of(scene), options.dt);
    fmt::print("100 tori of 600 triangles fall on a plane: {} steps, contacts by rays, {}\n", steps,
               simulation.world()->backend());
    FrameLog all, rays, gjk;
    std::vector<json> figures;
    {
        Progress progress("rays", steps);
        for (std::uint32_t i = 0; i < steps; ++i) {
            const FrameResult& result = simulation.step(options.dt, recording);
            all.add(result);
            figures.push_back(all.last_json());
            if (is_compared(i)) rays.add(result);
            progress.show(i + 1);
        }
    }
    all.print();

    const auto detector = scenes::make_detector(scene, scenes::Method::gjk_epa);
    {
        Progress progress("GJK/EPA", steps);
        for (std::uint32_t f = 0; f < steps; f += demo_stride) {
            scenes::put_frame(*detector, recording, f);
            const FrameResult result = detector->detect();
            if (is_compared(f)) gjk.add(result);
            progress.show(f + 1);
        }
    }
    fmt::print("\nTable 4 of the paper, 100 tori\n");
    print_table_4(rays, gjk);
    {
        Progress progress("page", steps);
        for (std::uint32_t i = 0; i < steps; ++i) {
            shown.step(options.dt);
            page.add(figures[i]);
            progress.show(i + 1);
        }
    }
    write_last_picture(*simulation.world(), scene, png);
    fmt::print("\npicture: {}\n", fs::absolute(png).string());
    json settings = detection_json(options.detection);
    settings.update({{"command", "demo"}, {"seed", options.seed}, {"dt", options.dt}});
    page.write(settings, {}, json::array());
    return 0;
}

}  // namespace pierce::app
