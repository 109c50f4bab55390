#include "scenes/named/tear_scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/named/shapes.hpp"

namespace pierce::scenes {
namespace {

constexpr double pull_seconds = 3, held_seconds = 3.5;

/// From 0 to 1 while the bodies are pulled.
double pulled(double time) { return std::min(time / pull_seconds, 1.0); }

/// A sheet that is cut a little way along x = 0 from the edge at the largest y.
MeshData notched_grid(double width, double depth, std::uint32_t nodes) {
    MeshData mesh = grid(width, depth, nodes, nodes);
    const std::uint32_t column = nodes / 2;
    const auto half_gap = static_cast<float>(0.1 * width / (nodes - 1));
    for (std::uint32_t row = nodes - nodes / 6; row < nodes; ++row) {
        const std::uint32_t cut = row * nodes + column;
        const auto copy = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(mesh.positions[cut]);
        mesh.positions[cut].x -= half_gap;
        mesh.positions[copy].x += half_gap;
        for (Triangle& t : mesh.triangles) {
            const bool is_beyond = std::ranges::any_of(
                t.vertex, [&](std::uint32_t v) { return v < nodes * nodes && v % nodes > column; });
            if (is_beyond) std::ranges::replace(t.vertex, cut, copy);
        }
    }
    return mesh;
}

/// A bar with round ends that is thinnest in its middle.
MeshData waisted_bar(double length) {
    MeshData mesh = sphere(1, 3);
    for (Vec3f& p : mesh.positions) {
        const double x = static_cast<double>(p.x), thickness = 0.1 + 0.1 * x * x;
        p = to_float({0.5 * length * x, thickness * length * static_cast<double>(p.y),
                      thickness * length * static_cast<double>(p.z)});
    }
    return mesh;
}

SceneBody pulled_sheet(std::uint32_t mesh, std::uint32_t nodes, double width, double depth) {
    SceneBody body{.name = "sheet",
                   .mesh = mesh,
                   .motion = Motion::deforming,
                   .pose = {{0, 0, 2.4}, {}},
                   .ground = false};
    const double spacing = width / (nodes - 1);
    body.collision = {SelfCollision::on, true, 0.05 * spacing};
    body.material.iterations = 60;
    body.tears = {.limit = 1.6, .most_at_once = 1};
    for (int side : {-1, 1}) {
        Guide edge;
        for (std::uint32_t j = 0; j < nodes; ++j)
            edge.vertices.push_back(j * nodes + (side < 0 ? 0 : nodes - 1));
        // The end of the edge beside the notch goes further, as in paper that is torn.
        edge.place = [=](Vec3d start, double time) -> std::optional<Vec3d> {
            if (time > held_seconds) return std::nullopt;
            const double way = 0.6 + 0.8 * start.y / depth;
            return start + Vec3d{side * 0.4 * width * pulled(time) * way, 0, 0};
        };
        body.guides.push_back(std::move(edge));
    }
    return body;
}

SceneBody pulled_solid(std::uint32_t mesh, const MeshData& data, double length) {
    SceneBody body{.name = "solid",
                   .mesh = mesh,
                   .motion = Motion::deforming,
                   .pose = {{0, -2, 0.4}, {}},
                   .ground = false,
                   .collision = {},
                   .shape_matching = 0};
    body.solid_iterations = 20;
    body.tears = {.limit = 1.6, .most_at_once = 2};
    for (std::uint32_t v = 0; v < data.positions.size(); ++v) {
        const Vec3d p = to_double(data.positions[v]), opposite{p.x, -p.y, -p.z};
        const auto away = [&](std::uint32_t u) {
            return length_squared(to_double(data.positions[u]) - opposite);
        };
        std::uint32_t nearest = 0;
        for (std::uint32_t u = 1; u < data.positions.size(); ++u)
            if (away(u) < away(nearest)) nearest = u;
        if (nearest != v) body.struts.emplace_back(v, nearest);
    }
    for (int side : {-1, 1}) {
        Guide end;
        for (std::uint32_t v = 0; v < data.positions.size(); ++v)
            if (side * static_cast<double>(data.positions[v].x) > 0.4 * length)
                end.vertices.push_back(v);
        end.place = [=](Vec3d start, double time) -> std::optional<Vec3d> {
            return start + Vec3d{side * 0.7 * length * pulled(time), 0, 0};
        };
        body.guides.push_back(std::move(end));
    }
    return body;
}

}  // namespace

SceneSetup tear(const SceneParameters& parameters) {
    constexpr double width = 2.4, depth = 1.6, length = 1.6;
    constexpr std::uint32_t plain_nodes = 30;
    const std::uint32_t nodes = parameters.nodes == 0 ? plain_nodes
                                                      : std::max(parameters.nodes, 2u);
    const MeshData solid = waisted_bar(length);
    SceneSetup scene{"tear",
                     {{"ground", box({-4, -4, -1}, {4, 4, 0}), {}},
                      {"sheet", notched_grid(width, depth, nodes), {}},
                      {"solid", solid, {}}},
                     {{"ground", 0, Motion::fixed, {}, true}}};
    scene.bodies.push_back(pulled_solid(2, solid, length));
    scene.bodies.push_back(pulled_sheet(1, nodes, width, depth));
    return scene;
}

}  // namespace pierce::scenes
