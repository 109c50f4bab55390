#include "scenes/recording/recording.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "core/base/usable.hpp"
#include "core/base/whole_file.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "scenes/files/json_index.hpp"
#include "scenes/files/mesh_io.hpp"
#include "scenes/files/npy.hpp"

namespace pierce::scenes {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* format_name = "pierce-recording";
// Recordings of bodies whose mesh changes have the second version, all others the first.
constexpr int plain_version = 1, format_version = 2;
constexpr std::size_t pose_size = 7;

constexpr std::array motion_names = {"static", "rigid", "deforming"};
constexpr std::array self_names = {"off", "on", "rays", "published"};

std::uint32_t mesh_of(const RecordedBody& body, std::uint32_t frame) {
    std::uint32_t mesh = body.mesh;
    for (const RecordedMeshChange& change : body.mesh_changes)
        if (change.frame <= frame) mesh = change.mesh;
    return mesh;
}

/// How many numbers there are for a body in a frame.
std::size_t frame_size(const Recording& recording, const RecordedBody& body, std::uint32_t frame) {
    if (body.motion != Motion::deforming) return pose_size;
    return 3 * recording.meshes[mesh_of(body, frame)].data.positions.size();
}

/// Where a frame's numbers begin among those of a body.
std::size_t frame_begin(const Recording& recording, const RecordedBody& body, std::uint32_t frame) {
    std::size_t begin = 0;
    std::uint32_t first = 0;
    for (const RecordedMeshChange& change : body.mesh_changes) {
        if (change.frame >= frame) break;
        begin += (change.frame - first) * frame_size(recording, body, first);
        first = change.frame;
    }
    return begin + (frame - first) * frame_size(recording, body, first);
}

/// The path of a file that must be inside the folder.
fs::path inside(const fs::path& folder, const std::string& name, const std::string& where) {
    const fs::path file(name);
    if (name.empty() || file.is_absolute() || std::ranges::find(file, fs::path("..")) != file.end())
        throw InputError(where + ": '" + name + "' is not a file inside the folder");
    return folder / file;
}

/// Throws for a key that has no meaning, such as one with a wrong letter.
void check_keys(const json& entry, const char* what, std::initializer_list<std::string_view> known,
                const std::string& where) {
    if (!entry.is_object()) throw InputError(where + ": " + what + " is no object");
    for (const auto& [key, value] : entry.items())
        if (std::ranges::find(known, key) == known.end())
            throw InputError(where + ": " + what + " has no '" + key + "'");
}

SceneMesh read_scene_mesh(const json& entry, const fs::path& folder, const std::string& where) {
    check_keys(entry, "a mesh", {"name", "file", "inside"}, where);
    const auto rule = inside_named(entry.value("inside", std::string(name(Inside::automatic))));
    if (!rule) throw InputError(where + ": inside is none of automatic, closed, winding and none");
    SceneMesh mesh{.name = entry.at("name").get<std::string>(),
                   .data = read_mesh(inside(folder, entry.at("file").get<std::string>(), where)),
                   .convex_pieces = {},
                   .inside = *rule};
    const std::size_t vertices = mesh.data.positions.size();
    for (const Triangle& t : mesh.data.triangles)
        for (const std::uint32_t v : t.vertex)
            if (v >= vertices)
                throw InputError(where + ": mesh '" + mesh.name + "' has no vertex " +
                                 std::to_string(v));
    return mesh;
}

json collision_json(const Collision& collision) {
    json entry{{"self", self_names[static_cast<std::size_t>(collision.self)]},
               {"sheet", collision.sheet},
               {"thickness", collision.thickness}};
    if (collision.margin >= 0) entry["margin"] = collision.margin;
    return entry;
}

/// Per mesh, a name that no other one has, as bodies name their meshes.
std::vector<std::string> names_of(std::span<const SceneMesh> meshes) {
    std::set<std::string> taken;
    for (const SceneMesh& mesh : meshes) taken.insert(mesh.name);
    std::set<std::string> used;
    std::vector<std::string> names;
    for (const SceneMesh& mesh : meshes) {
        std::string name = mesh.name;
        for (int k = 2; used.contains(name); ++k) {
            const std::string other = mesh.name + " " + std::to_string(k);
            if (!taken.contains(other)) name = other;
        }
        used.insert(name);
        names.push_back(std::move(name));
    }
    return names;
}

Collision read_collision(const json& entry, const std::string& where) {
    check_keys(entry, "a collision", {"self", "sheet", "thickness", "margin"}, where);
    const auto self = entry.value("self", std::string(self_names[0]));
    const auto known = std::ranges::find(self_names, self);
    if (known == self_names.end())
        throw InputError(where + ": self-collision is '" + self +
                         "'; there are off, on, rays, published");
    return {static_cast<SelfCollision>(known - self_names.begin()), entry.value("sheet", false),
            entry.value("thickness", 0.0), entry.value("margin", Collision{}.margin)};
}

void count_frames(std::size_t frames, const fs::path& file, Recording& recording) {
    if (frames == 0) throw InputError("'" + file.string() + "' has no frames");
    if (recording.frame_count == 0) recording.frame_count = static_cast<std::uint32_t>(frames);
    if (frames != recording.frame_count)
        throw InputError("'" + file.string() + "' has " + std::to_string(frames) +
                         " frames, and bodies before it have " +
                         std::to_string(recording.frame_count) +
                         "; only static bodies may have one instead");
}

std::uint32_t mesh_named(const std::string& mesh_name, const Recording& recording,
                         const RecordedBody& body, const std::string& where) {
    const auto mesh = std::ranges::find(recording.meshes, mesh_name, &SceneMesh::name);
    if (mesh == recording.meshes.end())
        throw InputError(where + ": body '" + body.name + "' names unknown mesh '" + mesh_name +
                         "'");
    return static_cast<std::uint32_t>(mesh - recording.meshes.begin());
}

void read_changes(const json& entries, const Recording& recording, RecordedBody& body,
                  const std::string& where) {
    if (body.motion != Motion::deforming)
        throw InputError(where + ": body '" + body.name + "' changes its mesh but does not deform");
    std::uint32_t last = 0;
    for (const json& entry : entries) {
        check_keys(entry, "a change", {"frame", "mesh"}, where);
        const std::uint32_t frame = index_in(entry.at("frame"), where);
        if (frame <= last || frame > constants::max_elements)
            throw InputError(where + ": the changes of body '" + body.name +
                             "' are not at ascending frames after the first");
        last = frame;
        body.mesh_changes.push_back(
            {last, mesh_named(entry.at("mesh").get<std::string>(), recording, body, where)});
    }
}

/// Takes the positions of a body whose mesh changes, all frames one after the other.
void take_changing_positions(FloatArray array, const fs::path& file, Recording& recording,
                             RecordedBody& body) {
    if (array.shape.size() != 2 || array.shape[1] != 3)
        throw InputError("'" + file.string() +
                         "' has the wrong shape: expected (vertices of all frames, 3)");
    const std::uint32_t from = body.mesh_changes.empty() ? 0 : body.mesh_changes.back().frame;
    const std::size_t begin = frame_begin(recording, body, from),
                      size = frame_size(recording, body, from);
    if (array.values.size() < begin + size || (array.values.size() - begin) % size != 0)
        throw InputError("'" + file.string() +
                         "' has the wrong shape: its vertices are not those of whole frames");
    count_frames(from + (array.values.size() - begin) / size, file, recording);
    body.values = std::move(array.values);
}

RecordedBody read_body(const json& entry, const fs::path& folder, Recording& recording,
                       const std::string& where) {
    check_keys(entry, "a body",
               {"name", "mesh", "motion", "poses", "positions", "ground", "collision", "changes"},
               where);
    RecordedBody body;
    body.name = entry.at("name").get<std::string>();
    body.ground = entry.value("ground", false);
    if (entry.contains("collision")) body.collision = read_collision(entry.at("collision"), where);
    body.mesh = mesh_named(entry.at("mesh").get<std::string>(), recording, body, where);
    const auto motion = entry.at("motion").get<std::string>();
    const auto known = std::ranges::find(motion_names, motion);
    if (known == motion_names.end())
        throw InputError(where + ": body '" + body.name + "' has motion '" + motion +
                         "'; there are static, rigid, deforming");
    body.motion = static_cast<Motion>(known - motion_names.begin());

    const bool deforms = body.motion == Motion::deforming;
    const fs::path file = inside(
        folder, entry.at(deforms ? "positions" : "poses").get<std::string>(), where);
    FloatArray array = read_npy(file);
    if (entry.contains("changes")) {
        read_changes(entry.at("changes"), recording, body, where);
        take_changing_positions(std::move(array), file, recording, body);
        return body;
    }
    const std::vector<std::size_t>
        tail = deforms
                   ? std::vector<std::size_t>{recording.meshes[body.mesh].data.positions.size(), 3}
                   : std::vector<std::size_t>{pose_size};
    if (array.shape.size() != tail.size() + 1 ||
        !std::equal(tail.begin(), tail.end(), array.shape.begin() + 1))
        throw InputError("'" + file.string() + "' has the wrong shape: expected (frames, " +
                         (deforms ? std::to_string(tail[0]) + ", 3)" : "7)"));
    const std::size_t frames = array.shape[0];
    if (body.motion != Motion::fixed || frames != 1) count_frames(frames, file, recording);
    body.values = std::move(array.values);
    return body;
}

double share(std::size_t done, std::size_t total) {
    return static_cast<double>(done) / static_cast<double>(total);
}

}  // namespace

Pose Recording::pose(std::uint32_t body, std::uint32_t frame) const {
    const std::vector<float>& v = bodies[body].values;
    const float* p = v.data() + (v.size() == pose_size ? 0 : pose_size * frame);
    return {{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}};
}

std::span<const float> Recording::numbers(std::uint32_t body, std::uint32_t frame) const {
    const RecordedBody& b = bodies[body];
    return {b.values.data() + frame_begin(*this, b, frame), frame_size(*this, b, frame)};
}

std::span<const Vec3f> Recording::positions(std::uint32_t body, std::uint32_t frame) const {
    static_assert(sizeof(Vec3f) == 3 * sizeof(float));
    const std::span<const float> all = numbers(body, frame);
    return {reinterpret_cast<const Vec3f*>(all.data()), all.size() / 3};
}

std::span<const Vec3f> Recording::start_positions(std::uint32_t body, std::uint32_t from,
                                                  std::uint32_t frame) const {
    return positions(body, mesh_of(body, from) == mesh_of(body, frame) ? from : frame);
}

std::uint32_t Recording::mesh_of(std::uint32_t body, std::uint32_t frame) const {
    return scenes::mesh_of(bodies[body], frame);
}

Inside inside_of(const Recording& recording, std::uint32_t mesh) {
    if (recording.meshes[mesh].inside != Inside::automatic) return recording.meshes[mesh].inside;
    for (const RecordedBody& body : recording.bodies)
        if (body.collision.sheet &&
            (body.mesh == mesh || std::ranges::any_of(body.mesh_changes, [&](const auto& change) {
                 return change.mesh == mesh;
             })))
            return Inside::none;
    return Inside::automatic;
}

void require_lasting_meshes(const Recording& recording, const std::string& what) {
    for (const RecordedBody& body : recording.bodies)
        if (!body.mesh_changes.empty())
            throw InputError(what + " needs meshes that stay, and that of body '" + body.name +
                             "' changes");
}

namespace {

/// A pose that a new body may have: that of the first frame that has one. A body whose pose is not
/// usable is left out of a frame.
Pose first_pose(const Recording& recording, std::uint32_t body) {
    for (std::uint32_t f = 0; f < recording.frame_count; ++f)
        if (const Pose pose = recording.pose(body, f); is_usable(pose)) return pose;
    return {};
}

}  // namespace

SceneSetup scene_of(const Recording& recording) {
    SceneSetup scene{"recording", recording.meshes, {}};
    for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
        const RecordedBody& body = recording.bodies[b];
        const Pose pose = body.motion == Motion::deforming ? Pose{} : first_pose(recording, b);
        scene.bodies.push_back(
            {body.name, body.mesh, body.motion, pose, body.ground, body.collision});
    }
    return scene;
}

void check_time_step(double dt, const std::string& what) {
    if (!(dt > 0) || std::isinf(dt)) throw InputError(what + " must be positive");
}

Recording start_recording(const SceneSetup& scene, double dt) {
    Recording recording{.dt = dt, .frame_count = 0, .meshes = scene.meshes, .bodies = {}};
    for (const SceneBody& b : scene.bodies)
        recording.bodies.push_back({.name = b.name,
                                    .mesh = b.mesh,
                                    .motion = b.motion,
                                    .ground = b.ground,
                                    .values = {},
                                    .collision = b.collision,
                                    .mesh_changes = {}});
    return recording;
}

void write_recording(const Recording& recording, const fs::path& folder,
                     const std::function<void(double)>& progress) {
    const fs::path scene_file = folder / "scene.json";
    std::error_code failed;
    fs::create_directories(folder, failed);
    // Without this file, which comes last, the folder is no recording. The truth is that of the
    // motion that was there before.
    for (const fs::path& old : {scene_file, folder / "truth.json", folder / "sheets.json"})
        fs::remove(old, failed);
    const bool changes = std::ranges::any_of(
        recording.bodies, [](const RecordedBody& b) { return !b.mesh_changes.empty(); });
    json scene{{"format", format_name},
               {"version", changes ? format_version : plain_version},
               {"dt", recording.dt},
               {"meshes", json::array()},
               {"bodies", json::array()}};
    const std::vector<std::string> names = names_of(recording.meshes);
    for (std::size_t m = 0; m < recording.meshes.size(); ++m) {
        const std::string file = "mesh_" + std::to_string(m) + ".obj";
        write_obj(folder / file, recording.meshes[m].data);
        scene["meshes"].push_back({{"name", names[m]}, {"file", file}});
        if (recording.meshes[m].inside != Inside::automatic)
            scene["meshes"].back()["inside"] = name(recording.meshes[m].inside);
    }
    for (std::size_t b = 0; b < recording.bodies.size(); ++b) {
        const RecordedBody& body = recording.bodies[b];
        const std::string file = "body_" + std::to_string(b) + ".npy";
        const std::size_t size = frame_size(recording, body, 0);
        std::vector<std::size_t> shape{body.values.size() / size, size};
        if (!body.mesh_changes.empty())
            shape = {body.values.size() / 3, 3};
        else if (body.motion == Motion::deforming)
            shape = {body.values.size() / size, size / 3, 3};
        write_npy(folder / file, shape, body.values);
        scene["bodies"].push_back(
            {{"name", body.name},
             {"mesh", names[body.mesh]},
             {"motion", motion_names[static_cast<std::size_t>(body.motion)]},
             {body.motion == Motion::deforming ? "positions" : "poses", file}});
        for (const RecordedMeshChange& change : body.mesh_changes)
            scene["bodies"].back()["changes"].push_back(
                {{"frame", change.frame}, {"mesh", names[change.mesh]}});
        if (body.ground) scene["bodies"].back()["ground"] = true;
        if (body.collision != Collision{})
            scene["bodies"].back()["collision"] = collision_json(body.collision);
        if (progress) progress(share(b + 1, recording.bodies.size()));
    }
    write_whole_file(scene_file, [&](std::ostream& out) {
        // Names need not be UTF-8.
        out << scene.dump(2, ' ', false, json::error_handler_t::replace) << '\n';
    });
}

Recording read_recording(const fs::path& folder, const std::function<void(double)>& progress) {
    const fs::path file = folder / "scene.json";
    const std::string where = "'" + file.string() + "'";
    std::ifstream in(file);
    if (!in) throw InputError("cannot open " + where);
    Recording recording;
    try {
        const json scene = json::parse(in);
        check_keys(scene, "a recording", {"format", "version", "dt", "meshes", "bodies"}, where);
        if (scene.at("format") != format_name) throw InputError(where + " is not a " + format_name);
        if (scene.at("version") != plain_version && scene.at("version") != format_version)
            throw InputError(where + " has version " + scene.at("version").dump() +
                             ", expected no more than " + std::to_string(format_version));
        recording.dt = scene.at("dt").get<double>();
        check_time_step(recording.dt, where + ": dt");
        for (const json& entry : scene.at("meshes")) {
            SceneMesh mesh = read_scene_mesh(entry, folder, where);
            if (std::ranges::find(recording.meshes, mesh.name, &SceneMesh::name) !=
                recording.meshes.end())
                throw InputError(where + ": two meshes are named '" + mesh.name + "'");
            recording.meshes.push_back(std::move(mesh));
        }
        for (const json& entry : scene.at("bodies")) {
            recording.bodies.push_back(read_body(entry, folder, recording, where));
            if (entry.contains("changes") && scene.at("version") == plain_version)
                throw InputError(where + ": a recording with changes has version 2");
            if (progress) progress(share(recording.bodies.size(), scene.at("bodies").size()));
        }
    } catch (const json::exception& error) {
        throw InputError(where + ": " + error.what());
    }
    if (recording.bodies.empty()) throw InputError(where + " has no bodies");
    if (recording.frame_count == 0) recording.frame_count = 1;
    return recording;
}

}  // namespace pierce::scenes
