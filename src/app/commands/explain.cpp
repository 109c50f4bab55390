#include "app/commands/explain.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "app/commands/commands.hpp"
#include "app/measure/recording_files.hpp"
#include "app/output/detection_json.hpp"
#include "app/output/frame_log.hpp"
#include "app/output/json_file.hpp"
#include "app/output/progress.hpp"
#include "app/output/provenance.hpp"
#include "app/output/waiting.hpp"
#include "pierce/error.hpp"
#include "pierce/world.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/files/mesh_io.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* reason_names[] = {
    "contact",        "excluded",       "filtered",       "both_fixed",   "boxes_apart",
    "open_target",    "outside_box",    "outside_solid",  "no_direction", "entry_first",
    "nothing_ahead",  "not_inside_own", "own_exit_first", "beyond_range", "not_looked_at",
    "not_looked_for", "apart",          "close_at_rest",  "beside"};
static_assert(std::size(reason_names) == static_cast<std::size_t>(Reason::beside) + 1);
constexpr const char* certificate_names[] = {"none", "patch", "patch_rest", "vertex"};

json to_json(const Explanation& e) {
    json result{{"reason", reason_names[static_cast<int>(e.reason)]},
                {"text", e.text()},
                {"distance", e.distance},
                {"t", e.t},
                {"own_exit", e.own_exit},
                {"triangle", nullptr},
                {"certificate", nullptr},
                {"contact", nullptr}};
    if (e.triangle != no_triangle) result["triangle"] = e.triangle;
    if (e.certificate.kind != Certificate::none)
        result["certificate"] = {{"kind", certificate_names[e.certificate.kind]},
                                 {"left", e.certificate.left}};
    if (e.contact) result["contact"] = contact_json(*e.contact);
    return result;
}

/// Bodies of a world, and what people call them.
struct Question {
    BodyId body, other;
    std::string body_name, other_name;
    json settings;
};

/// `world` has taken the step that is asked about.
void answer(World& world, const Question& question, const ExplainOptions& options) {
    const Explanation explanation = world.explain(question.body, question.other, options.vertex);
    const Vec3d p = world.vertex_position(question.body, options.vertex);
    for (const std::string& note : world.plan().notes) fmt::print("note: {}\n", note);
    fmt::print("vertex {} of {}, at {:.6g} {:.6g} {:.6g}, against {}\n{}\n", options.vertex,
               question.body_name, p.x, p.y, p.z, question.other_name, explanation.text());
    if (options.json.empty()) return;
    json settings = rays_json(options.rays);
    settings.update(question.settings);
    settings.update({{"command", "explain"}, {"vertex", options.vertex}});
    write_json_file(options.json, {{"machine", machine_json()},
                                   {"versions", versions_json()},
                                   {"settings", settings},
                                   {"position", xyz(p)},
                                   {"explanation", to_json(explanation)}});
}

void explain_meshes(const ExplainOptions& options) {
    if (options.frame || !options.bodies.empty())
        throw InputError("--frame and --bodies are for recordings, not for meshes");
    World world(scenes::make_backend(options.rays), options.rays.world);
    std::vector<BodyId> bodies;
    std::vector<std::string> names;
    for (const fs::path& file : options.inputs) {
        const Waiting waiting("reading " + file.string());
        names.push_back(file.string());
        bodies.push_back(world.add_rigid_body(
            world.add_mesh(names.back(), scenes::read_mesh(file), options.rays.mesh_options())));
    }
    const std::string of = options.of.value_or("a");
    const std::size_t body = of == "a" ? 0 : 1, other = 1 - body;
    world.detect();
    answer(
        world,
        {bodies[body], bodies[other], names[body], names[other], {{"meshes", names}, {"of", of}}},
        options);
}

void explain_recording(const ExplainOptions& options) {
    const fs::path& folder = options.inputs[0];
    if (fs::is_regular_file(folder))
        throw InputError("'" + folder.string() +
                         "' is one file: give two meshes, or a recording's folder");
    if (options.of)
        throw InputError("--of is for meshes; in a recording the first of --bodies has the vertex");
    if (!options.frame || options.bodies.empty())
        throw InputError("a recording needs --frame and --bodies");
    const scenes::Recording recording = load_recording(folder);
    const std::string where = "'" + folder.string() + "' has ";
    if (*options.frame >= recording.frame_count)
        throw InputError(fmt::format("{}frames 0 to {}, no frame {}", where,
                                     recording.frame_count - 1, *options.frame));
    for (std::uint32_t b : options.bodies)
        if (b >= recording.bodies.size())
            throw InputError(
                fmt::format("{}bodies 0 to {}, no body {}", where, recording.bodies.size() - 1, b));
    const std::uint32_t body = options.bodies[0], other = options.bodies[1];
    const scenes::SceneMesh& mesh = recording.meshes[recording.mesh_of(body, *options.frame)];
    if (options.vertex >= mesh.data.positions.size())
        throw InputError(fmt::format("mesh '{}' has no vertex {}", mesh.name, options.vertex));

    const auto detector = scenes::make_detector(scenes::scene_of(recording), scenes::Method::rays,
                                                options.rays);
    World& world = *detector->world();
    // A World gives out handles in order, and a scene never removes a body.
    const BodyId body_id{body, 1}, other_id{other, 1};
    {
        Progress progress("replaying", *options.frame + 1);
        for (std::uint32_t f = 0; f <= *options.frame; ++f) {
            scenes::put_frame(*detector, recording, f);
            detector->detect();
            progress.show(f + 1);
        }
    }
    const auto name = [&](std::uint32_t b) {
        return fmt::format("body {} '{}'", b, recording.bodies[b].name);
    };
    fmt::print("{}, frame {}\n", folder.string(), *options.frame);
    const json settings{{"folder", folder.filename().string()},
                        {"frame", *options.frame},
                        {"bodies", options.bodies}};
    answer(world, {body_id, other_id, name(body), name(other), settings}, options);
}

}  // namespace

int explain(const ExplainOptions& options) {
    check_writable(options.json);
    if (options.inputs.size() == 2)
        explain_meshes(options);
    else
        explain_recording(options);
    return 0;
}

}  // namespace pierce::app
