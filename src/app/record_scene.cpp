#include "record_scene.hpp"

#include <algorithm>
#include <cmath>

#include "pierce/scenes/simulation.hpp"
#include "progress.hpp"

namespace pierce::app {

scenes::Recording record_scene(const std::string& name, const scenes::SceneParameters& parameters, double seconds,
                               double dt) {
    const scenes::SceneSetup scene = scenes::make_scene(name, parameters);
    scenes::Simulation simulation(scene, scenes::Method::rays, {"embree", 0, {}});
    scenes::Recording recording = scenes::start_recording(scene, dt);
    const auto steps = std::max(1u, static_cast<std::uint32_t>(std::lround(seconds / dt)));
    Progress progress("simulating " + name, steps);
    for (std::uint32_t i = 0; i < steps; ++i) {
        simulation.record(recording);
        simulation.step(dt);
        progress.show(i + 1);
    }
    return recording;
}

}  // namespace pierce::app
