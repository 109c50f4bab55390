#include "scenes/simulate/crossing_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "pierce/error.hpp"
#include "scenes/named/layers.hpp"
#include "scenes/named/scene.hpp"
#include "scenes/simulate/simulation.hpp"

namespace pierce::scenes {
namespace {

/// Thickness of a surface for which no thickness is given [mean edge length].
constexpr double thickness_share = 0.1;

std::uint32_t step_count(const CrossingMotionParameters& p) {
    if (!(p.seconds > 0) || !(p.dt > 0)) throw InputError("a motion takes some time");
    return static_cast<std::uint32_t>(std::max(1L, std::lround(p.seconds / p.dt)));
}

/// Makes every deforming body a sheet whose contacts with itself are looked for.
void look_for_itself(Recording& recording) {
    for (RecordedBody& body : recording.bodies) {
        if (body.motion != Motion::deforming) continue;
        body.collision.self = SelfCollision::on;
        if (body.collision.sheet) continue;
        const SceneMesh& mesh = recording.meshes[body.mesh];
        body.collision.sheet = true;
        body.collision.thickness = thickness_share *
                                   Mesh(mesh.name, mesh.data).traits().mean_edge_length;
    }
}

/// Simulates sheets that are kept off other bodies, but not off themselves.
Recording simulated(const std::string& name, const CrossingMotionParameters& parameters) {
    SceneSetup scene = make_scene(name, {.seed = parameters.seed, .nodes = parameters.nodes});
    for (SceneBody& body : scene.bodies) body.collision.self = SelfCollision::off;
    Simulation simulation(scene, Method::rays);
    Recording recording = start_recording(scene, parameters.dt);
    for (std::uint32_t i = 0; i < step_count(parameters); ++i) {
        simulation.record(recording);
        simulation.step(parameters.dt);
    }
    look_for_itself(recording);
    return recording;
}

/// A stack of small sheets, in which every other sheet sinks through its neighbour and comes back.
Recording crossing_layers(const CrossingMotionParameters& parameters) {
    constexpr std::uint32_t nodes = 16, sheets = 8;
    constexpr double sinks = 2.4, period = 2;  // [thickness], [s]
    Layers layers = layers_with(parameters.nodes == 0 ? nodes : parameters.nodes);
    layers.sheets = sheets;
    Recording recording = start_recording(layers.scene(), parameters.dt);
    recording.frame_count = step_count(parameters);
    std::vector<Vec3f> at(layers.vertex_count());
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        const double time = f * parameters.dt;
        const double down = 0.5 * sinks * layers.thickness *
                            (1 - std::cos(2 * std::numbers::pi * time / period));
        for (std::uint32_t s = 0; s < sheets; ++s) {
            layers.positions(s, time, at);
            std::vector<float>& values = recording.bodies[s].values;
            for (const Vec3f& p : at)
                values.insert(values.end(),
                              {p.x, p.y, static_cast<float>(p.z - (s % 2 == 1 ? down : 0.0))});
        }
    }
    return recording;
}

}  // namespace

std::span<const std::string> crossing_motion_names() {
    static const std::vector<std::string> names{"cloth-capsule", "cloth-fold", "cloth-twist",
                                                "ball-squash", "layers"};
    return names;
}

Recording crossing_motion(const std::string& name, const CrossingMotionParameters& parameters) {
    if (std::ranges::find(crossing_motion_names(), name) == crossing_motion_names().end())
        throw InputError("scene '" + name + "' has no sheets");
    return name == "layers" ? crossing_layers(parameters) : simulated(name, parameters);
}

}  // namespace pierce::scenes
