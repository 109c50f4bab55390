#include "scenes/named/cloth_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "scenes/named/shapes.hpp"

namespace pierce::scenes {
namespace {

using std::numbers::pi;

/// Thickness of a sheet [distance of its vertices]: as thick as a sheet can be without its own
/// folds being in its way.
constexpr double thickness_share = 0.1;

/// Vertices along a side of the sheets, unless others are asked for.
constexpr std::uint32_t plain_nodes = 20, plain_rings = 24;

/// The step for a sheet of `nodes` vertices a side [s]. In such a step, what falls or is led moves
/// as many distances of vertices as with the scene's own sheet in 1/60 s: about a third of one. In
/// longer steps many layers would be passed at once. A round over the links passes a motion on by
/// one link. So a finer sheet needs more steps, with as many rounds each, to be as stiff.
double step_for(std::uint32_t nodes, std::uint32_t plain) {
    return SceneSetup{}.dt * std::min(1.0, (plain - 1.0) / (nodes - 1.0));
}

/// A material that loses the same share of velocity in a second, whatever the step.
SheetMaterial material_for(double dt) {
    SheetMaterial material;
    material.damping = 1 - std::pow(1 - material.damping, dt / SceneSetup{}.dt);
    return material;
}

std::uint32_t nodes_or(const SceneParameters& parameters, std::uint32_t standard) {
    return parameters.nodes == 0 ? standard : std::max(parameters.nodes, 2u);
}

SceneBody sheet_body(std::string name, std::uint32_t mesh, double spacing, double dt) {
    SceneBody body{.name = std::move(name),
                   .mesh = mesh,
                   .motion = Motion::deforming,
                   .pose = {},
                   .ground = false};
    body.collision = {SelfCollision::on, true, thickness_share * spacing};
    body.material = material_for(dt);
    return body;
}

SceneMesh ground_below(double half_width) {
    return {"ground", box({-half_width, -half_width, -1}, {half_width, half_width, 0}), {}};
}

/// Straight from 0 to 1 within `duration`, starting and ending at rest.
double eased(double time, double duration) {
    const double t = std::clamp(time / duration, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

}  // namespace

SceneSetup cloth_capsule(const SceneParameters& parameters) {
    constexpr double width = 7.6, capsule_radius = 0.6, capsule_half_length = 0.5, height = 2.6,
                     drop = 0.6;
    const std::uint32_t nodes = nodes_or(parameters, plain_nodes);
    SceneSetup scene{"cloth-capsule",
                     {ground_below(8),
                      {"capsule", capsule(capsule_radius, capsule_half_length, 32, 10), {}},
                      {"sheet", grid(width, width, nodes, nodes), {}}},
                     {{"ground", 0, Motion::fixed, {}, true},
                      {"capsule", 1, Motion::fixed, {{0, 0, height}, {}}, false}}};
    scene.dt = step_for(nodes, plain_nodes);
    SceneBody sheet = sheet_body("sheet", 2, width / (nodes - 1), scene.dt);
    std::mt19937 random(parameters.seed);
    const double turn = 0.5 * pi * static_cast<double>(random()) / 4294967296.0;
    sheet.pose = {{0.3, 0.2, height + capsule_radius + drop},
                  {0, 0, std::sin(0.5 * turn), std::cos(0.5 * turn)}};
    scene.bodies.push_back(std::move(sheet));
    return scene;
}

SceneSetup cloth_fold(const SceneParameters& parameters) {
    constexpr double width = 4.0, radius = 1.9, duration = 2.0, end = 0.97 * pi;
    const std::uint32_t nodes = nodes_or(parameters, plain_nodes);
    SceneSetup scene{"cloth-fold",
                     {ground_below(4), {"sheet", grid(width, width, nodes, nodes), {}}},
                     {{"ground", 0, Motion::fixed, {}, true}}};
    scene.dt = step_for(nodes, plain_nodes);
    SceneBody sheet = sheet_body("sheet", 1, width / (nodes - 1), scene.dt);
    sheet.pose.position.z = sheet.collision.thickness;
    Guide edge;
    for (std::uint32_t j = 0; j < nodes; ++j) edge.vertices.push_back(j * nodes);
    edge.place = [=](Vec3d start, double time) -> std::optional<Vec3d> {
        if (time > duration) return std::nullopt;
        const double angle = end * eased(time, duration);
        return start + radius * Vec3d{1 - std::cos(angle), 0, std::sin(angle)};
    };
    sheet.guides.push_back(std::move(edge));
    scene.bodies.push_back(std::move(sheet));
    return scene;
}

SceneSetup cloth_catch(const SceneParameters& parameters) {
    constexpr double width = 2, height = 1.5, drop = 0.4, radius = 0.22;
    const std::uint32_t nodes = nodes_or(parameters, plain_nodes);
    SceneSetup scene{"cloth-catch",
                     {ground_below(4),
                      {"ball", sphere(radius, 2), {}},
                      {"torus", torus(0.7 * radius, 0.3 * radius, 20, 10), {}},
                      {"sheet", grid(width, width, nodes, nodes), {}}},
                     {{"ground", 0, Motion::fixed, {}, true}}};
    scene.dt = step_for(nodes, plain_nodes);
    for (int i = 0; i < 4; ++i) {
        const double side = i % 2 == 0 ? -1 : 1, level = height + drop + 2.5 * radius * i;
        scene.bodies.push_back({"solid " + std::to_string(i),
                                i < 2 ? 1u : 2u,
                                Motion::rigid,
                                {{0.3 * side, 0.1 * side * (i - 1), level}, {0.3 * i, 0.2, 0, 1}},
                                false});
    }
    SceneBody sheet = sheet_body("sheet", 3, width / (nodes - 1), scene.dt);
    sheet.pose.position.z = height;
    sheet.guides.push_back({{0, nodes - 1, nodes * (nodes - 1), nodes * nodes - 1},
                            [](Vec3d start, double) -> std::optional<Vec3d> { return start; }});
    scene.bodies.push_back(std::move(sheet));
    return scene;
}

SceneSetup cloth_twist(const SceneParameters& parameters) {
    constexpr double radius = 0.5, height = 2.5, turns = 3.0, duration = 6.0, nearer = 1.0;
    const std::uint32_t rings = nodes_or(parameters, plain_rings);
    SceneSetup scene{.name = "cloth-twist",
                     .meshes = {{"tube", tube(radius, height, rings, rings), {}}},
                     .bodies = {},
                     .gravity = 0};
    scene.dt = step_for(rings, plain_rings);
    SceneBody sheet = sheet_body("tube", 0, 2 * pi * radius / rings, scene.dt);
    for (int side : {-1, 1}) {
        Guide end;
        for (std::uint32_t i = 0; i < rings; ++i)
            end.vertices.push_back(side < 0 ? i : (rings - 1) * rings + i);
        end.place = [=](Vec3d start, double time) -> std::optional<Vec3d> {
            const double part = eased(time, duration), angle = side * pi * turns * part;
            const double c = std::cos(angle), s = std::sin(angle);
            return Vec3d{c * start.x - s * start.y, s * start.x + c * start.y,
                         start.z - side * 0.5 * nearer * part};
        };
        sheet.guides.push_back(std::move(end));
    }
    scene.bodies.push_back(std::move(sheet));
    return scene;
}

namespace {

/// A ball with a deep groove around its equator, closed.
MeshData grooved_ball(std::uint32_t around) {
    constexpr double lip = 0.32, groove_radius = 0.35;
    const double step = 2 * pi / around;
    std::vector<std::pair<double, double>> upper;  // radius and height, from the pole to the bottom
                                                   // of the groove
    const double lip_angle = std::asin(lip);
    const auto arc = static_cast<int>(std::lround((0.5 * pi - lip_angle) / step));
    for (int i = 1; i <= arc; ++i) {
        const double angle = 0.5 * pi - i * (0.5 * pi - lip_angle) / arc;
        upper.emplace_back(std::cos(angle), std::sin(angle));
    }
    const double inner = std::cos(lip_angle) - groove_radius;
    const auto wall = static_cast<int>(std::lround(inner / step));
    for (int i = 1; i <= wall; ++i) upper.emplace_back(std::cos(lip_angle) - i * inner / wall, lip);
    const auto floor = static_cast<int>(std::lround(lip / step));
    for (int i = 1; i < floor; ++i)
        upper.emplace_back(groove_radius, lip * (1 - static_cast<double>(i) / floor));
    std::vector<std::pair<double, double>> rings = upper;
    rings.emplace_back(groove_radius, 0);
    for (std::size_t i = upper.size(); i-- > 0;)
        rings.emplace_back(upper[i].first, -upper[i].second);

    MeshData mesh;
    mesh.positions.push_back({0, 0, 1});
    for (const auto& [r, z] : rings)
        for (std::uint32_t i = 0; i < around; ++i)
            mesh.positions.push_back(to_float({r * std::cos(i * step), r * std::sin(i * step), z}));
    mesh.positions.push_back({0, 0, -1});
    const auto last = static_cast<std::uint32_t>(mesh.positions.size()) - 1, bottom = last - around;
    for (std::uint32_t i = 0; i < around; ++i) {
        const std::uint32_t next = (i + 1) % around;
        mesh.triangles.push_back({{0, 1 + i, 1 + next}});
        mesh.triangles.push_back({{last, bottom + next, bottom + i}});
        for (std::uint32_t j = 0; j + 1 < rings.size(); ++j) {
            const std::uint32_t a = 1 + j * around + i, b = 1 + j * around + next;
            mesh.triangles.push_back({{a, a + around, b + around}});
            mesh.triangles.push_back({{a, b + around, b}});
        }
    }
    return mesh;
}

}  // namespace

SceneSetup ball_squash(const SceneParameters& parameters) {
    constexpr double half_width = 2, plate = 0.5, gap = 0.02, press = 0.75, duration = 2.0;
    const std::uint32_t around = parameters.nodes == 0 ? 40 : std::max(parameters.nodes, 16u);
    const MeshData plate_mesh = box({-half_width, -half_width, -0.5 * plate},
                                    {half_width, half_width, 0.5 * plate});
    SceneSetup scene{.name = "ball-squash",
                     .meshes = {{"plate", plate_mesh, {plate_mesh.positions}},
                                {"ball", grooved_ball(around), {}}},
                     .bodies = {},
                     .gravity = 0};
    for (int side : {-1, 1}) {
        const double start = side * (1 + gap + 0.5 * plate);
        SceneBody body{.name = side < 0 ? "lower plate" : "upper plate",
                       .mesh = 0,
                       .motion = Motion::fixed,
                       .pose = {{0, 0, start}, {}},
                       .ground = false};
        body.path = [=](double time) {
            return Pose{{0, 0, start - side * press * eased(time, duration)}, {}};
        };
        scene.bodies.push_back(std::move(body));
    }
    SceneBody ball{
        .name = "ball", .mesh = 1, .motion = Motion::deforming, .pose = {}, .ground = false};
    ball.collision.self = SelfCollision::on;
    ball.shape_matching = 0.02;
    scene.bodies.push_back(std::move(ball));
    return scene;
}

}  // namespace pierce::scenes
