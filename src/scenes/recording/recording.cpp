#include "scenes/recording/recording.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pierce/error.hpp"
#include "scenes/files/mesh_io.hpp"
#include "scenes/files/npy.hpp"

namespace pierce::scenes {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* format_name = "pierce-recording";
constexpr int format_version = 1;
constexpr std::size_t pose_size = 7;

constexpr std::array motion_names = {"static", "rigid", "deforming"};
constexpr std::array self_names = {"off", "on", "rays", "published"};

std::size_t frame_size(const Recording& recording, const RecordedBody& body) {
    if (body.motion != Motion::deforming) return pose_size;
    return 3 * recording.meshes[body.mesh].data.positions.size();
}

/// The path of a file that must be inside the folder.
fs::path inside(const fs::path& folder, const std::string& name, const std::string& where) {
    const fs::path file(name);
    if (name.empty() || file.is_absolute() || std::ranges::find(file, fs::path("..")) != file.end())
        throw InputError(where + ": '" + name + "' is not a file inside the folder");
    return folder / file;
}

SceneMesh read_scene_mesh(const json& entry, const fs::path& folder, const std::string& where) {
    const auto rule = inside_named(entry.value("inside", std::string(name(Inside::automatic))));
    if (!rule) throw InputError(where + ": inside is none of automatic, closed, winding and none");
    return {entry.at("name").get<std::string>(),
            read_mesh(inside(folder, entry.at("file").get<std::string>(), where)),
            {},
            *rule};
}

json collision_json(const Collision& collision) {
    return {{"self", self_names[static_cast<std::size_t>(collision.self)]},
            {"sheet", collision.sheet},
            {"thickness", collision.thickness}};
}

Collision read_collision(const json& entry, const std::string& where) {
    const auto self = entry.value("self", std::string(self_names[0]));
    const auto known = std::ranges::find(self_names, self);
    if (known == self_names.end())
        throw InputError(where + ": self-collision is '" + self +
                         "'; there are off, on, rays, published");
    return {static_cast<SelfCollision>(known - self_names.begin()), entry.value("sheet", false),
            entry.value("thickness", 0.0)};
}

RecordedBody read_body(const json& entry, const fs::path& folder, Recording& recording,
                       const std::string& where) {
    RecordedBody body;
    body.name = entry.at("name").get<std::string>();
    body.ground = entry.value("ground", false);
    if (entry.contains("collision")) body.collision = read_collision(entry.at("collision"), where);
    const auto mesh_name = entry.at("mesh").get<std::string>();
    const auto mesh = std::ranges::find(recording.meshes, mesh_name, &SceneMesh::name);
    if (mesh == recording.meshes.end())
        throw InputError(where + ": body '" + body.name + "' names unknown mesh '" + mesh_name +
                         "'");
    body.mesh = static_cast<std::uint32_t>(mesh - recording.meshes.begin());
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
    const std::vector<std::size_t>
        tail = deforms ? std::vector<std::size_t>{mesh->data.positions.size(), 3}
                       : std::vector<std::size_t>{pose_size};
    if (array.shape.size() != tail.size() + 1 ||
        !std::equal(tail.begin(), tail.end(), array.shape.begin() + 1))
        throw InputError("'" + file.string() + "' has the wrong shape: expected (frames, " +
                         (deforms ? std::to_string(tail[0]) + ", 3)" : "7)"));
    const std::size_t frames = array.shape[0];
    if (body.motion != Motion::fixed || frames != 1) {
        if (recording.frame_count == 0) recording.frame_count = static_cast<std::uint32_t>(frames);
        if (frames != recording.frame_count)
            throw InputError("'" + file.string() + "' has " + std::to_string(frames) +
                             " frames, others have " + std::to_string(recording.frame_count));
    }
    body.values = std::move(array.values);
    return body;
}

}  // namespace

Pose Recording::pose(std::uint32_t body, std::uint32_t frame) const {
    const std::vector<float>& v = bodies[body].values;
    const float* p = v.data() + (v.size() == pose_size ? 0 : pose_size * frame);
    return {{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}};
}

std::span<const Vec3f> Recording::positions(std::uint32_t body, std::uint32_t frame) const {
    static_assert(sizeof(Vec3f) == 3 * sizeof(float));
    const std::size_t count = meshes[bodies[body].mesh].data.positions.size();
    return {reinterpret_cast<const Vec3f*>(bodies[body].values.data()) + count * frame, count};
}

SceneSetup scene_of(const Recording& recording) {
    SceneSetup scene{"recording", recording.meshes, {}};
    for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
        const RecordedBody& body = recording.bodies[b];
        const Pose pose = body.motion == Motion::deforming ? Pose{} : recording.pose(b, 0);
        scene.bodies.push_back(
            {body.name, body.mesh, body.motion, pose, body.ground, body.collision});
    }
    return scene;
}

Recording start_recording(const SceneSetup& scene, double dt) {
    Recording recording{.dt = dt, .frame_count = 0, .meshes = scene.meshes, .bodies = {}};
    for (const SceneBody& b : scene.bodies)
        recording.bodies.push_back({.name = b.name,
                                    .mesh = b.mesh,
                                    .motion = b.motion,
                                    .ground = b.ground,
                                    .values = {},
                                    .collision = b.collision});
    return recording;
}

void write_recording(const Recording& recording, const fs::path& folder) {
    std::error_code failed;
    fs::create_directories(folder, failed);
    json scene{{"format", format_name},
               {"version", format_version},
               {"dt", recording.dt},
               {"meshes", json::array()},
               {"bodies", json::array()}};
    for (std::size_t m = 0; m < recording.meshes.size(); ++m) {
        const std::string file = "mesh_" + std::to_string(m) + ".obj";
        write_obj(folder / file, recording.meshes[m].data);
        scene["meshes"].push_back({{"name", recording.meshes[m].name}, {"file", file}});
        if (recording.meshes[m].inside != Inside::automatic)
            scene["meshes"].back()["inside"] = name(recording.meshes[m].inside);
    }
    for (std::size_t b = 0; b < recording.bodies.size(); ++b) {
        const RecordedBody& body = recording.bodies[b];
        const std::string file = "body_" + std::to_string(b) + ".npy";
        const std::size_t frames = body.values.size() / frame_size(recording, body);
        std::vector<std::size_t> shape{frames, pose_size};
        if (body.motion == Motion::deforming)
            shape = {frames, recording.meshes[body.mesh].data.positions.size(), 3};
        write_npy(folder / file, shape, body.values);
        scene["bodies"].push_back(
            {{"name", body.name},
             {"mesh", recording.meshes[body.mesh].name},
             {"motion", motion_names[static_cast<std::size_t>(body.motion)]},
             {body.motion == Motion::deforming ? "positions" : "poses", file}});
        if (body.ground) scene["bodies"].back()["ground"] = true;
        if (body.collision != Collision{})
            scene["bodies"].back()["collision"] = collision_json(body.collision);
    }
    std::ofstream out(folder / "scene.json");
    out << scene.dump(2) << '\n';
    if (!out.flush()) throw InputError("cannot write '" + (folder / "scene.json").string() + "'");
}

Recording read_recording(const fs::path& folder) {
    const fs::path file = folder / "scene.json";
    const std::string where = "'" + file.string() + "'";
    std::ifstream in(file);
    if (!in) throw InputError("cannot open " + where);
    Recording recording;
    try {
        const json scene = json::parse(in);
        if (scene.at("format") != format_name) throw InputError(where + " is not a " + format_name);
        if (scene.at("version") != format_version)
            throw InputError(where + " has version " + scene.at("version").dump() + ", expected " +
                             std::to_string(format_version));
        recording.dt = scene.at("dt").get<double>();
        if (!(recording.dt > 0)) throw InputError(where + ": dt must be positive");
        for (const json& entry : scene.at("meshes"))
            recording.meshes.push_back(read_scene_mesh(entry, folder, where));
        for (const json& entry : scene.at("bodies"))
            recording.bodies.push_back(read_body(entry, folder, recording, where));
    } catch (const json::exception& error) {
        throw InputError(where + ": " + error.what());
    }
    if (recording.bodies.empty()) throw InputError(where + " has no bodies");
    if (recording.frame_count == 0) recording.frame_count = 1;
    return recording;
}

namespace {

/// Every Nth frame of those from `first` on, before `end`.
Recording picked(const Recording& recording, std::uint32_t first, std::uint32_t end,
                 std::uint32_t every) {
    Recording result = recording;
    result.dt = every * recording.dt;
    result.frame_count = (end - first + every - 1) / every;
    for (RecordedBody& body : result.bodies) {
        const std::size_t size = frame_size(recording, body);
        // A body that stays has one frame.
        if (body.values.size() == size) continue;
        std::vector<float> kept;
        for (std::uint32_t f = first; f < end; f += every)
            kept.insert(kept.end(), body.values.begin() + static_cast<std::ptrdiff_t>(f * size),
                        body.values.begin() + static_cast<std::ptrdiff_t>((f + 1) * size));
        body.values = std::move(kept);
    }
    return result;
}

}  // namespace

Recording excerpt(const Recording& recording, std::uint32_t first, std::uint32_t count) {
    const std::uint32_t begin = std::min(first, recording.frame_count);
    return picked(recording, begin, begin + std::min(count, recording.frame_count - begin), 1);
}

Recording thinned(const Recording& recording, std::uint32_t frames) {
    return picked(recording, 0, recording.frame_count,
                  std::max(1u, recording.frame_count / std::max(frames, 1u)));
}

Recording as_deforming(const Recording& recording) {
    Recording result = recording;
    for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
        if (recording.bodies[b].motion != Motion::rigid) continue;
        RecordedBody& body = result.bodies[b];
        body.motion = Motion::deforming;
        body.values.clear();
        for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
            const Frame frame = frame_of(recording.pose(b, f));
            for (Vec3f rest : recording.meshes[body.mesh].data.positions) {
                const Vec3f p = to_float(frame.to_parent(to_double(rest)));
                body.values.insert(body.values.end(), {p.x, p.y, p.z});
            }
        }
    }
    return result;
}

}  // namespace pierce::scenes
