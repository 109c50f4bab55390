#include "fuzz/program.hpp"

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace pierce::fuzz {
namespace {

using nlohmann::json;

constexpr const char* names[] = {"add_mesh",
                                 "remove_mesh",
                                 "add_fixed_body",
                                 "add_rigid_body",
                                 "add_deforming_body",
                                 "remove_body",
                                 "set_collision",
                                 "set_pose",
                                 "set_positions",
                                 "set_pose_motion",
                                 "set_position_motion",
                                 "set_mesh",
                                 "set_filter",
                                 "exclude",
                                 "include",
                                 "replicate",
                                 "copy_places",
                                 "remove_world",
                                 "set_world_active",
                                 "forget_sides",
                                 "detect",
                                 "explain",
                                 "cast_rays",
                                 "probe",
                                 "overlap",
                                 "parting",
                                 "impacts",
                                 "restore"};
static_assert(std::size(names) == static_cast<std::size_t>(Call::Kind::restore) + 1);

// JSON has no numbers that are not finite.
json number(double x) {
    if (std::isnan(x)) return "nan";
    if (std::isinf(x)) return x > 0 ? "inf" : "-inf";
    return x;
}
double number_of(const json& j) {
    if (j.is_number()) return j.get<double>();
    const auto text = j.get<std::string>();
    if (text != "nan" && text != "inf" && text != "-inf")
        throw std::runtime_error("no number: " + text);
    return text == "nan" ? std::nan("") : text == "inf" ? HUGE_VAL : -HUGE_VAL;
}

template <class Vec>
json vector(const Vec& v) {
    return json::array({number(static_cast<double>(v.x)), number(static_cast<double>(v.y)),
                        number(static_cast<double>(v.z))});
}
template <class Vec>
Vec vector_of(const json& j) {
    using Real = decltype(Vec::x);
    return {static_cast<Real>(number_of(j.at(0))), static_cast<Real>(number_of(j.at(1))),
            static_cast<Real>(number_of(j.at(2)))};
}

json points(const std::vector<Vec3f>& all) {
    json j = json::array();
    for (const Vec3f& p : all) j.push_back(vector(p));
    return j;
}
std::vector<Vec3f> points_of(const json& j) {
    std::vector<Vec3f> all;
    for (const json& p : j) all.push_back(vector_of<Vec3f>(p));
    return all;
}

json pose(const Pose& p) {
    const Quaternion& q = p.rotation;
    return {{"position", vector(p.position)},
            {"rotation", json::array({number(q.x), number(q.y), number(q.z), number(q.w)})}};
}
Pose pose_of(const json& j) {
    const json& q = j.at("rotation");
    return {vector_of<Vec3d>(j.at("position")),
            {number_of(q.at(0)), number_of(q.at(1)), number_of(q.at(2)), number_of(q.at(3))}};
}

template <class Enum>
Enum enum_of(const json& j, Enum last) {
    const auto value = j.get<unsigned>();
    if (value > static_cast<unsigned>(last))
        throw std::runtime_error("no such choice: " + std::to_string(value));
    return static_cast<Enum>(value);
}

json settings(const Settings& s) {
    return {{"coverage", static_cast<int>(s.coverage)},
            {"reproject", s.reproject},
            {"temporal", static_cast<int>(s.temporal)},
            {"predict", s.predict},
            {"may_rest", s.may_rest},
            {"prediction_distance", number(s.prediction_distance)},
            {"full_every", s.full_every},
            {"walk_threshold", number(s.walk_threshold)},
            {"open_body_range", number(s.open_body_range)},
            {"margin", number(s.margin)}};
}
Settings settings_of(const json& j) {
    Settings s;
    s.coverage = enum_of(j.at("coverage"), Coverage::overlaps);
    s.reproject = j.at("reproject");
    s.temporal = enum_of(j.at("temporal"), Temporal::certified);
    s.predict = j.at("predict");
    s.may_rest = j.value("may_rest", false);
    s.prediction_distance = number_of(j.at("prediction_distance"));
    s.full_every = j.at("full_every");
    s.walk_threshold = number_of(j.at("walk_threshold"));
    s.open_body_range = number_of(j.at("open_body_range"));
    s.margin = number_of(j.value("margin", json(0.0)));
    return s;
}

json call(const Call& c) {
    using Kind = Call::Kind;
    json j = {{"call", name_of(c.kind)}};
    const auto any_of = [&](std::initializer_list<Kind> kinds) {
        return std::find(kinds.begin(), kinds.end(), c.kind) != kinds.end();
    };
    if (c.kind == Kind::add_mesh) {
        j["positions"] = points(c.data.positions);
        j["triangles"] = json::array();
        for (const Triangle& t : c.data.triangles) j["triangles"].push_back(t.vertex);
        if (c.before != Call::no_mesh) j["before"] = c.before;
        if (c.inside != Inside::automatic) j["inside"] = static_cast<int>(c.inside);
    }
    if (any_of({Kind::remove_mesh, Kind::add_fixed_body, Kind::add_rigid_body,
                Kind::add_deforming_body, Kind::set_mesh}))
        j["mesh"] = c.mesh;
    if (any_of({Kind::remove_body, Kind::set_collision, Kind::set_pose, Kind::set_positions,
                Kind::set_pose_motion, Kind::set_position_motion, Kind::set_mesh, Kind::explain,
                Kind::set_filter, Kind::exclude, Kind::include, Kind::overlap, Kind::parting}))
        j["body"] = c.body;
    if (any_of({Kind::add_fixed_body, Kind::add_rigid_body, Kind::set_pose, Kind::set_pose_motion,
                Kind::cast_rays}))
        j["pose"] = pose(c.pose);
    if (c.kind == Kind::set_pose_motion) j["start"] = pose(c.start_pose);
    if (any_of({Kind::add_deforming_body, Kind::set_positions, Kind::set_position_motion,
                Kind::set_mesh, Kind::cast_rays, Kind::probe}))
        j["positions"] = points(c.positions);
    if (any_of({Kind::set_position_motion, Kind::probe})) j["start"] = points(c.start);
    if (c.kind == Kind::probe) j["radius"] = number(c.radius);
    if (any_of({Kind::replicate, Kind::copy_places, Kind::remove_world, Kind::set_world_active}))
        j["world"] = c.world;
    if (c.kind == Kind::copy_places) j["other_world"] = c.other_world;
    if (any_of({Kind::replicate, Kind::impacts})) j["count"] = c.count;
    if (c.kind == Kind::set_world_active) j["active"] = c.active;
    if (c.kind == Kind::set_collision) {
        j["self"] = static_cast<int>(c.collision.self);
        j["sheet"] = c.collision.sheet;
        j["thickness"] = number(c.collision.thickness);
        j["margin"] = number(c.collision.margin);
    }
    if (c.kind == Kind::set_filter) {
        j["groups"] = c.filter.groups;
        j["meets"] = c.filter.meets;
        j["chain"] = c.filter.chain;
        j["world"] = c.filter.world;
    }
    if (any_of({Kind::exclude, Kind::include, Kind::overlap, Kind::parting})) j["other"] = c.other;
    if (c.kind == Kind::explain) {
        j["other"] = c.other;
        j["vertex"] = c.vertex;
    }
    return j;
}
Call call_of(const json& j) {
    using Kind = Call::Kind;
    Call c;
    const auto name = j.at("call").get<std::string>();
    const auto* const at = std::find(std::begin(names), std::end(names), name);
    if (at == std::end(names)) throw std::runtime_error("no such call: " + name);
    c.kind = static_cast<Kind>(at - std::begin(names));
    c.mesh = j.value("mesh", 0u);
    c.body = j.value("body", 0u);
    c.other = j.value("other", 0u);
    c.vertex = j.value("vertex", 0u);
    if (j.contains("pose")) c.pose = pose_of(j["pose"]);
    if (c.kind == Kind::set_pose_motion) c.start_pose = pose_of(j.at("start"));
    if (c.kind == Kind::set_position_motion || c.kind == Kind::probe)
        c.start = points_of(j.at("start"));
    c.count = j.value("count", 0u);
    c.active = j.value("active", true);
    c.other_world = j.value("other_world", 0);
    if (c.kind != Kind::set_filter) c.world = j.value("world", 0);
    c.radius = number_of(j.value("radius", json(0.0)));
    if (c.kind == Kind::add_mesh) {
        c.data.positions = points_of(j.at("positions"));
        for (const json& t : j.at("triangles"))
            c.data.triangles.push_back({{t.at(0), t.at(1), t.at(2)}});
        c.before = j.value("before", Call::no_mesh);
        c.inside = enum_of(j.value("inside", json(0)), Inside::none);
    } else if (j.contains("positions")) {
        c.positions = points_of(j["positions"]);
    }
    if (c.kind == Kind::set_collision)
        c.collision = {.self = enum_of(j.at("self"), SelfCollision::published),
                       .sheet = j.at("sheet"),
                       .thickness = number_of(j.at("thickness")),
                       .margin = number_of(j.value("margin", json(-1.0)))};
    if (c.kind == Kind::set_filter)
        c.filter = {.groups = j.at("groups"),
                    .meets = j.at("meets"),
                    .chain = j.at("chain"),
                    .world = j.at("world")};
    return c;
}

}  // namespace

const char* name_of(Call::Kind kind) { return names[static_cast<std::size_t>(kind)]; }

std::string to_text(const Program& program) {
    std::string text = "{\"settings\": " + settings(program.settings).dump() + ",\n \"calls\": [\n";
    for (std::size_t i = 0; i < program.calls.size(); ++i)
        text += "  " + call(program.calls[i]).dump() +
                (i + 1 < program.calls.size() ? ",\n" : "\n");
    return text + "]}\n";
}

Program program_of(const std::string& text) {
    const json j = json::parse(text);
    Program program;
    program.settings = settings_of(j.at("settings"));
    for (const json& c : j.at("calls")) program.calls.push_back(call_of(c));
    return program;
}

}  // namespace pierce::fuzz
