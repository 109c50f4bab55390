#include "scenes/named/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "pierce/error.hpp"
#include "scenes/named/bunny.hpp"
#include "scenes/named/cloth_scenes.hpp"
#include "scenes/named/layers.hpp"
#include "scenes/named/shapes.hpp"
#include "scenes/named/tear_scene.hpp"

namespace pierce::scenes {
namespace {

const std::array<SceneInfo, 9> scene_infos = {{
    {.name = "tori",
     .description = "tori of 300 vertices and 600 triangles (radii 2 and 0.5) fall on a plane",
     .has_count = true,
     .may_be_soft = true,
     .has_seed = true,
     .has_nodes = true},
    {.name = "bunnies",
     .description = "Stanford bunnies of 453 vertices and 902 triangles fall on a plane",
     .has_count = true,
     .may_be_soft = true,
     .has_seed = true},
    {.name = "cloth-capsule",
     .description = "a sheet of 20 x 20 vertices falls on a capsule, on the ground and on itself",
     .has_seed = true,
     .has_nodes = true},
    {.name = "cloth-fold",
     .description = "a sheet is folded onto itself and let go",
     .has_nodes = true},
    {.name = "cloth-catch",
     .description = "a sheet held at its corners catches solids",
     .has_nodes = true},
    {.name = "cloth-twist", .description = "a tube of cloth is wrung", .has_nodes = true},
    {.name = "layers",
     .description = "50 sheets, 475000 triangles in all, swing and slide in a stack as a formula "
                    "says",
     .has_nodes = true},
    {.name = "ball-squash",
     .description = "a soft ball with a groove is pressed between two plates until the groove "
                    "closes",
     .has_nodes = true},
    {.name = "tear",
     .description = "a sheet and a soft solid are pulled until they tear, and fall",
     .has_nodes = true},
}};

constexpr double ground_half_width = 60;
constexpr double ground_thickness = 10;

SceneMesh ground_mesh() {
    MeshData data = box({-ground_half_width, -ground_half_width, -ground_thickness},
                        {ground_half_width, ground_half_width, 0});
    std::vector<Vec3f> corners = data.positions;
    return {"ground", std::move(data), {std::move(corners)}};
}

/// A torus of `nodes` vertices around its hole, and a third of that around its tube.
SceneMesh torus_mesh(std::uint32_t nodes) {
    constexpr std::uint32_t plain_nodes = 30, least_nodes = 9;
    const std::uint32_t around = nodes == 0 ? plain_nodes : std::max(nodes, least_nodes),
                        across = around / 3;
    SceneMesh mesh{"torus", torus(2, 0.5, around, across), {}};
    for (std::uint32_t i = 0; i < around; ++i) {
        std::vector<Vec3f> piece;
        for (std::uint32_t ring : {i, (i + 1) % around})
            for (std::uint32_t j = 0; j < across; ++j)
                piece.push_back(mesh.data.positions[ring * across + j]);
        mesh.convex_pieces.push_back(std::move(piece));
    }
    return mesh;
}

/// Bounding sphere radius around the origin.
double radius_of(const MeshData& mesh) {
    double r = 0;
    for (Vec3f p : mesh.positions) r = std::max(r, length(to_double(p)));
    return r;
}

/// A scene of `count` bodies of one mesh, let go above the ground in loose layers with random
/// rotations. The column is narrow, so that the bodies land on each other.
SceneSetup falling(std::string name, SceneMesh mesh, const SceneParameters& parameters) {
    const double spacing = 2.1 * radius_of(mesh.data);
    const auto side = static_cast<std::uint32_t>(std::ceil(std::cbrt(parameters.count / 2.0)));
    std::mt19937 random(parameters.seed);
    // The random engine's numbers are the same on every platform; those of the standard's
    // distributions are not.
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0 * 2 - 1; };

    SceneSetup scene{std::move(name),
                     {ground_mesh(), std::move(mesh)},
                     {{"ground", 0, Motion::fixed, {}, true}}};
    for (std::uint32_t i = 0; i < parameters.count; ++i) {
        SceneBody body{.name = scene.meshes[1].name + " " + std::to_string(i),
                       .mesh = 1,
                       .motion = parameters.soft ? Motion::deforming : Motion::rigid,
                       .pose = {},
                       .ground = false};
        const auto layer = i / (side * side);
        const Vec3d cell{static_cast<double>(i % side), static_cast<double>(i / side % side),
                         static_cast<double>(layer)};
        const double middle = 0.5 * (side - 1);
        body.pose.position = {spacing * (cell.x - middle), spacing * (cell.y - middle),
                              spacing * (cell.z + 0.6)};
        body.pose.rotation = {uniform(), uniform(), uniform(), uniform()};
        scene.bodies.push_back(std::move(body));
    }
    return scene;
}

}  // namespace

std::span<const SceneInfo> scene_list() { return scene_infos; }

SceneSetup make_scene(const std::string& name, const SceneParameters& parameters) {
    if (parameters.count == 0) throw InputError("scene '" + name + "' needs at least one body");
    if (name == "tori") return falling(name, torus_mesh(parameters.nodes), parameters);
    if (name == "bunnies") return falling(name, bunny_mesh(), parameters);
    if (name == "cloth-capsule") return cloth_capsule(parameters);
    if (name == "cloth-fold") return cloth_fold(parameters);
    if (name == "cloth-catch") return cloth_catch(parameters);
    if (name == "cloth-twist") return cloth_twist(parameters);
    if (name == "layers") return layers_with(parameters.nodes).scene();
    if (name == "ball-squash") return ball_squash(parameters);
    if (name == "tear") return tear(parameters);
    std::string known;
    for (const SceneInfo& info : scene_list()) known += (known.empty() ? "" : ", ") + info.name;
    throw InputError("unknown scene '" + name + "'; there are: " + known);
}

}  // namespace pierce::scenes
