#include "cloth_motions.hpp"

#include <cmath>
#include <numbers>

#include "cloth_report.hpp"
#include "pierce/scenes/layers.hpp"
#include "pierce/scenes/scene.hpp"

namespace pierce::app {
namespace {

/// Thickness of a surface that has none of its own [mean edge length].
constexpr double thickness_share = 0.1;

/// Makes every deforming body a sheet that is looked for in itself.
void look_for_itself(scenes::Recording& recording) {
    for (scenes::RecordedBody& body : recording.bodies) {
        if (body.motion != Motion::deforming) continue;
        body.collision.self = SelfCollision::on;
        if (body.collision.sheet) continue;
        const scenes::SceneMesh& mesh = recording.meshes[body.mesh];
        body.collision.sheet = true;
        body.collision.thickness = thickness_share * Mesh(mesh.name, mesh.data).traits().mean_edge_length;
    }
}

/// Sheets kept off other bodies, but not off themselves.
scenes::Recording simulated(const std::string& name, const ClothReportOptions& options) {
    scenes::SceneSetup scene = scenes::make_scene(name, {.seed = options.seed, .nodes = options.nodes});
    for (scenes::SceneBody& body : scene.bodies) body.collision.self = SelfCollision::off;
    scenes::Recording recording = simulate(scene, scenes::Method::rays, {}, options.timing).recording;
    recording.frame_count = options.timing.steps();
    look_for_itself(recording);
    return recording;
}

/// A stack of small sheets every other one of which sinks through its neighbour and comes back.
scenes::Recording crossing_layers(const ClothReportOptions& options) {
    constexpr std::uint32_t nodes = 16, sheets = 8;
    constexpr double sinks = 2.4, period = 2;  // [thickness], [s]
    scenes::Layers layers = scenes::layers_with(nodes);
    layers.sheets = sheets;
    scenes::Recording recording = scenes::start_recording(layers.scene(), options.timing.dt);
    recording.frame_count = options.timing.steps();
    std::vector<Vec3f> at(layers.vertex_count());
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        const double time = f * options.timing.dt;
        const double down = 0.5 * sinks * layers.thickness * (1 - std::cos(2 * std::numbers::pi * time / period));
        for (std::uint32_t s = 0; s < sheets; ++s) {
            layers.positions(s, time, at);
            for (const Vec3f& p : at) {
                const double z = p.z - (s % 2 == 1 ? down : 0.0);
                recording.bodies[s].values.insert(recording.bodies[s].values.end(), {p.x, p.y, static_cast<float>(z)});
            }
        }
    }
    return recording;
}

}  // namespace

std::vector<ClothMotion> crossing_motions(const ClothReportOptions& options) {
    std::vector<ClothMotion> motions;
    for (const auto& [name, what] : {std::pair{"cloth-capsule", "a sheet falls on a capsule and on the ground"},
                                     {"cloth-fold", "a sheet is folded"},
                                     {"cloth-twist", "a tube of cloth is wrung"},
                                     {"ball-squash", "a ball with a groove is pressed flat; its surface"}})
        motions.push_back({name, what, simulated(name, options)});
    motions.push_back({"layers", "every other sheet of a stack sinks through the next one", crossing_layers(options)});
    return motions;
}

}  // namespace pierce::app
