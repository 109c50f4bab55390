#include <algorithm>
#include <array>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <type_traits>

#include "core/base/whole_file.hpp"
#include "pierce/constants.hpp"
#include "pierce/error.hpp"
#include "scenes/files/json_index.hpp"
#include "scenes/files/mesh_io.hpp"
#include "scenes/files/npy.hpp"
#include "scenes/recording/frame_layout.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::scenes {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* format_name = "pierce-recording";
/// What a recording needs of a reader, by what is in it.
enum Version { plain = 1, with_changes = 2, with_filters = 3 };
constexpr int newest = with_filters;

constexpr std::array motion_names = {"static", "rigid", "deforming"};
constexpr std::array self_names = {"off", "on", "rays", "published"};

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

json filter_json(const Filter& filter) {
    return {{"groups", filter.groups},
            {"meets", filter.meets},
            {"chain", filter.chain},
            {"world", filter.world}};
}

Filter read_filter(const json& entry, const std::string& where) {
    check_keys(entry, "a filter", {"groups", "meets", "chain", "world"}, where);
    Filter filter;
    const auto read = [&](const char* key, auto& value) {
        using Value = std::remove_reference_t<decltype(value)>;
        const auto given = entry.find(key);
        if (given == entry.end()) return;
        const auto number = given->is_number_integer() ? given->template get<std::int64_t>() : -2;
        if (number < (std::is_signed_v<Value> ? all_worlds : 0) ||
            number > std::int64_t{std::numeric_limits<Value>::max()})
            throw InputError(where + ": a filter's " + key + " cannot be " + given->dump());
        value = static_cast<Value>(number);
    };
    read("groups", filter.groups);
    read("meets", filter.meets);
    read("chain", filter.chain);
    read("world", filter.world);
    return filter;
}

std::set<BodyPair> read_excluded(const json& entries, std::size_t bodies,
                                 const std::string& where) {
    std::set<BodyPair> excluded;
    for (const json& entry : entries) {
        if (!entry.is_array() || entry.size() != 2)
            throw InputError(where + ": an excluded pair is no list of two bodies");
        const std::uint32_t a = index_in(entry[0], where), b = index_in(entry[1], where);
        if (a >= bodies || b >= bodies || a == b)
            throw InputError(where + ": bodies " + entry.dump() + " are no pair");
        excluded.insert(std::minmax(a, b));
    }
    return excluded;
}

Version version_of(const Recording& recording) {
    const auto any = [&](const auto& has) { return std::ranges::any_of(recording.bodies, has); };
    if (!recording.excluded.empty() ||
        any([](const RecordedBody& b) { return b.filter != Filter{}; }))
        return with_filters;
    return any([](const RecordedBody& b) { return !b.mesh_changes.empty(); }) ? with_changes
                                                                              : plain;
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
               {"name", "mesh", "motion", "poses", "positions", "ground", "collision", "filter",
                "changes"},
               where);
    RecordedBody body;
    body.name = entry.at("name").get<std::string>();
    body.ground = entry.value("ground", false);
    if (entry.contains("collision")) body.collision = read_collision(entry.at("collision"), where);
    if (entry.contains("filter")) body.filter = read_filter(entry.at("filter"), where);
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

void write_recording(const Recording& recording, const fs::path& folder,
                     const std::function<void(double)>& progress) {
    const fs::path scene_file = folder / "scene.json";
    std::error_code failed;
    fs::create_directories(folder, failed);
    // Without this file, which comes last, the folder is no recording. The truth is that of the
    // motion that was there before.
    for (const fs::path& old : {scene_file, folder / "truth.json", folder / "sheets.json"})
        fs::remove(old, failed);
    json scene{{"format", format_name},
               {"version", version_of(recording)},
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
        if (body.filter != Filter{}) scene["bodies"].back()["filter"] = filter_json(body.filter);
        if (progress) progress(share(b + 1, recording.bodies.size()));
    }
    if (!recording.excluded.empty()) scene["excluded"] = recording.excluded;
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
        check_keys(scene, "a recording",
                   {"format", "version", "dt", "meshes", "bodies", "excluded"}, where);
        if (scene.at("format") != format_name) throw InputError(where + " is not a " + format_name);
        const json& version = scene.at("version");
        if (!version.is_number_integer() || version < int{plain} || version > newest)
            throw InputError(where + " has version " + version.dump() + ", expected no more than " +
                             std::to_string(newest));
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
            if (progress) progress(share(recording.bodies.size(), scene.at("bodies").size()));
        }
        if (scene.contains("excluded"))
            recording.excluded = read_excluded(scene.at("excluded"), recording.bodies.size(),
                                               where);
        if (version < int{version_of(recording)})
            throw InputError(where + " has version " + version.dump() +
                             ", and what is in it has version " +
                             std::to_string(version_of(recording)));
    } catch (const json::exception& error) {
        throw InputError(where + ": " + error.what());
    }
    if (recording.bodies.empty()) throw InputError(where + " has no bodies");
    if (recording.frame_count == 0) recording.frame_count = 1;
    return recording;
}

}  // namespace pierce::scenes
