#include "app/commands/validate.hpp"

#include <fmt/core.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>

#include "app/commands/commands.hpp"
#include "app/commands/detection_page.hpp"
#include "app/measure/compare.hpp"
#include "app/measure/recording_files.hpp"
#include "app/output/detection_json.hpp"
#include "app/output/frame_log.hpp"
#include "app/output/json_file.hpp"
#include "app/output/progress.hpp"
#include "app/output/provenance.hpp"
#include "app/output/waiting.hpp"
#include "pierce/error.hpp"
#include "scenes/measure/validation.hpp"
#include "scenes/simulate/simulation.hpp"

namespace pierce::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using scenes::Validation;
using scenes::WrongContact;

/// Vertices times triangles that brute force takes in its stride: more than 100 bunnies of 902
/// triangles have.
constexpr double reference_limit = 1e8;
/// So many wrong contacts are printed; all of them are in the JSON file.
constexpr std::size_t printed_contacts = 20;

scenes::Recording simulate(const ValidateOptions& options) {
    constexpr double dt = 1.0 / 60;
    const RunOptions defaults;
    const scenes::SceneSetup scene = scenes::make_scene(
        options.input, {options.count.value_or(defaults.count), options.soft, defaults.seed});
    scenes::RaySettings rays;
    rays.mesh_progress = show_meshes();
    scenes::Simulation simulation(scene, scenes::Method::rays, rays);
    scenes::Recording recording = scenes::start_recording(scene, dt);
    const auto steps = static_cast<std::uint32_t>(
        std::max(1.0, options.seconds.value_or(defaults.seconds) / dt + 0.5));
    Progress progress("simulating", steps);
    for (std::uint32_t i = 0; i < steps; ++i) {
        simulation.step(dt, recording);
        progress.show(i + 1);
    }
    return recording;
}

scenes::Recording frames_of(const ValidateOptions& options) {
    if (std::ranges::find(scenes::scene_list(), options.input, &scenes::SceneInfo::name) !=
        scenes::scene_list().end())
        return simulate(options);
    if (!fs::is_directory(options.input))
        throw InputError("'" + options.input +
                         "' is neither a scene, see 'pierce scenes', nor a recording's folder");
    if (options.count || options.soft || options.seconds)
        throw InputError("--count, --soft and --seconds are for scenes, not for recordings");
    return load_recording(options.input);
}

bool is_small(const scenes::Recording& recording) {
    double vertices = 0, triangles = 0;
    for (const scenes::RecordedBody& body : recording.bodies) {
        const MeshData& mesh = recording.meshes[body.mesh].data;
        vertices += static_cast<double>(mesh.positions.size());
        triangles = std::max(triangles, static_cast<double>(mesh.triangles.size()));
    }
    return vertices * triangles <= reference_limit;
}

std::vector<scenes::Candidate> asked_for(const std::vector<std::string>& backends) {
    std::vector<scenes::Candidate> candidates;
    candidates.reserve(backends.size());
    for (const std::string& name : backends)
        candidates.push_back({name, scenes::make_backend({name})});
    return candidates;
}

/// The backends that can run here, and the reasons for those left out.
std::vector<scenes::Candidate> all_for(const scenes::Recording& recording,
                                       std::vector<std::string>& left_out) {
    std::vector<scenes::Candidate> candidates;
    for (const std::string name : {"reference", "bvh", "embree", "cuda"}) {
        if (name == "reference" && !is_small(recording)) {
            left_out.push_back(name +
                               ": brute force takes long on a scene of this size; --backends runs "
                               "it all the same");
            continue;
        }
        try {
            candidates.push_back({name, scenes::make_backend({name})});
        } catch (const InputError& error) {
            left_out.push_back(name + ": " + error.what());
        }
    }
    return candidates;
}

std::string describe(const std::optional<Contact>& contact) {
    if (!contact) return "no contact";
    return fmt::format("triangle {}, depth {:.9g}", contact->triangle,
                       contact->penetration_depth());
}

void print(const WrongContact& wrong, const Validation& validation) {
    const Contact& c = wrong.difference.subject();
    fmt::print("  frame {}, {} {} of body {} against body {}: {} has {}; right is {}{}\n",
               wrong.frame, c.is_edge() ? "edge" : "vertex", c.is_edge() ? c.edge : c.vertex,
               c.source_body().index, c.target_body().index,
               validation.results[wrong.candidate].name, describe(wrong.difference.found),
               describe(wrong.difference.right), wrong.near_tie ? " (a near tie)" : "");
}

void print(const Validation& validation) {
    fmt::print("  {:<11}{:>8}{:>12}{:>14}{:>16}{:>11}\n", "backend", "frames", "contacts",
               "wrong frames", "wrong contacts", "ms median");
    for (const Validation::Result& r : validation.results)
        fmt::print("  {:<11}{:>8}{:>12}{:>14}{:>16}{:>11.3f}  {}\n", r.name, validation.frames,
                   r.contacts, r.wrong_frames, r.wrong_contacts, spread_of(r.ms).median,
                   r.description);
    for (std::size_t i = 0; i < std::min(validation.wrong.size(), printed_contacts); ++i)
        print(validation.wrong[i], validation);
    if (validation.wrong.size() > printed_contacts)
        fmt::print("  and {} more\n", validation.wrong.size() - printed_contacts);
}

/// What all backends found in one mode.
struct ModeResult {
    std::string mode;
    Validation validation;
};

std::string verdict(const ModeResult& result) {
    const Validation& validation = result.validation;
    std::string text = fmt::format("{}: backends differ in {} of {} frames", result.mode,
                                   validation.differing_frames, validation.frames);
    for (const Validation::Result& r : validation.results)
        if (r.wrong_contacts > 0)
            text += fmt::format("; {} is wrong about {} contacts, {} of them near ties", r.name,
                                r.wrong_contacts, r.near_ties);
    return text;
}

bool agree(const ModeResult& result) { return result.validation.differing_frames == 0; }

std::string verdict(const std::vector<ModeResult>& results) {
    std::string text;
    for (const ModeResult& result : results)
        if (!agree(result)) text += (text.empty() ? "" : "\n") + verdict(result);
    return text.empty() ? "all backends have the same contacts in every frame" : text;
}

Settings settings_of(const ValidateOptions& options, const std::string& mode) {
    const Settings& remembering = compared_method_named(mode).settings;
    Settings settings = options.world;
    settings.temporal = remembering.temporal;
    settings.predict = remembering.predict;
    return settings;
}

json to_json(const std::optional<Contact>& contact) {
    return contact ? contact_json(*contact) : json();
}

json to_json(const ModeResult& result) {
    const Validation& validation = result.validation;
    json backends = json::array(), wrong = json::array();
    for (const Validation::Result& r : validation.results) {
        const Spread ms = spread_of(r.ms);
        backends.push_back({{"backend", r.name},
                            {"description", r.description},
                            {"contacts", r.contacts},
                            {"wrong_frames", r.wrong_frames},
                            {"wrong_contacts", r.wrong_contacts},
                            {"near_ties", r.near_ties},
                            {"ms", {{"median", ms.median}, {"p95", ms.p95}, {"max", ms.max}}}});
    }
    for (const WrongContact& w : validation.wrong)
        wrong.push_back({{"frame", w.frame},
                         {"backend", validation.results[w.candidate].name},
                         {"near_tie", w.near_tie},
                         {"found", to_json(w.difference.found)},
                         {"right", to_json(w.difference.right)}});
    return {{"mode", result.mode},
            {"frames", validation.frames},
            {"differing_frames", validation.differing_frames},
            {"backends", backends},
            {"wrong", wrong}};
}

/// What the page's charts show of every frame: the time of every backend, and how many contacts
/// are wrong.
std::vector<json> frames_json(const std::vector<ModeResult>& results, std::uint32_t every) {
    std::vector<json> frames(results.front().validation.frames);
    for (const ModeResult& result : results)
        for (const Validation::Result& r : result.validation.results)
            for (std::size_t k = 0; k < frames.size(); ++k)
                frames[k]["ms"][r.name + ", " + result.mode] = r.ms[k];
    for (const ModeResult& result : results)
        for (const WrongContact& w : result.validation.wrong) {
            json& count = frames[w.frame / every]["wrong_contacts"];
            count = count.is_null() ? 1 : count.get<int>() + 1;
        }
    return frames;
}

json tables_json(const std::vector<ModeResult>& results) {
    json rows = json::array(), wrong = json::array();
    for (const ModeResult& result : results) {
        for (const Validation::Result& r : result.validation.results)
            rows.push_back({result.mode, r.name, r.contacts, r.wrong_frames, r.wrong_contacts,
                            spread_of(r.ms).median});
        for (const WrongContact& w : result.validation.wrong)
            wrong.push_back({result.mode, w.frame, result.validation.results[w.candidate].name,
                             describe(w.difference.found), describe(w.difference.right)});
    }
    return {{{"title", verdict(results)},
             {"columns",
              {"mode", "backend", "contacts", "wrong frames", "wrong contacts", "ms, median"}},
             {"rows", rows}},
            {{"title", "Wrong contacts"},
             {"columns", {"mode", "frame", "backend", "found", "right"}},
             {"rows", wrong}}};
}

}  // namespace

int validate(const ValidateOptions& options) {
    check_writable(options.json);
    check_writable(options.page.file);
    check_different({options.json, options.page.file});
    asked_for(options.backends);  // refuses unknown names before anything is simulated
    const scenes::Recording recording = frames_of(options);
    std::vector<std::string> left_out;
    std::vector<ModeResult> results;
    const auto stop = until_interrupted([&] {
        for (const std::string& mode : options.modes) {
            left_out.clear();
            std::vector<scenes::Candidate> candidates = options.backends.empty()
                                                            ? all_for(recording, left_out)
                                                            : asked_for(options.backends);
            Progress progress("validating " + mode, recording.frame_count);
            std::optional<Waiting> making("validating " + mode + ": making meshes");
            results.push_back({mode, scenes::validate(recording, std::move(candidates),
                                                      settings_of(options, mode), options.every,
                                                      [&](std::uint32_t n) {
                                                          making.reset();
                                                          progress.show(n);
                                                      })});
        }
    });
    if (stop && results.empty()) throw *stop;
    const std::vector<std::string> missing(
        options.modes.begin() + static_cast<std::ptrdiff_t>(results.size()), options.modes.end());
    fmt::print("{}: {} bodies, {} of {} frames\n", options.input, recording.bodies.size(),
               results.front().validation.frames, recording.frame_count);
    for (const ModeResult& result : results) {
        fmt::print(" {}\n", result.mode);
        print(result.validation);
    }
    for (const std::string& line : left_out) fmt::print("  left out: {}\n", line);
    const std::string found = verdict(results) + (stop ? "; modes are missing" : "");
    fmt::print("{}\n", found);
    json settings = rays_json({.backend = {}, .threads = 0, .world = options.world});
    for (const char* other : {"backend", "threads", "temporal", "predict", "inside", "mesh_cache",
                              "parts", "host_share"})
        settings.erase(other);
    settings.update({{"command", "validate"}, {"input", options.input}, {"every", options.every}});
    if (!fs::is_directory(options.input)) {
        const RunOptions defaults;
        settings.update({{"count", options.count.value_or(defaults.count)},
                         {"soft", options.soft},
                         {"seconds", options.seconds.value_or(defaults.seconds)},
                         {"seed", defaults.seed}});
    }
    if (stop) settings["missing_modes"] = missing;
    if (!options.json.empty()) {
        json modes = json::array();
        for (const ModeResult& result : results) modes.push_back(to_json(result));
        write_json_file(options.json, {{"modes", modes},
                                       {"machine", machine_json()},
                                       {"versions", versions_json()},
                                       {"settings", settings},
                                       {"left_out", left_out},
                                       {"verdict", found}});
    }
    if (stop) {
        fmt::print(stderr, "pierce: {}: missing are the modes {}{}\n", stop->what(),
                   fmt::join(missing, ", "),
                   options.page.file.empty() ? "" : ", and " + options.page.file.string());
        return 1;
    }
    write_page_of(recording, options.page, {.world = options.world}, options.input,
                  frames_json(results, options.every), options.every, settings,
                  tables_json(results),
                  fs::is_directory(options.input) ? fs::path(options.input) : fs::path());
    return std::ranges::all_of(results, agree) ? 0 : 1;
}

}  // namespace pierce::app
