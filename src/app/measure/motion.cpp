#include "app/measure/motion.hpp"

#include <algorithm>
#include <cmath>

#include "app/output/progress.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/simulate/simulation.hpp"

namespace pierce::app {
namespace {

scenes::RaySettings settings_of(const Settings& rays, int threads) {
    scenes::RaySettings settings{"embree", threads, rays};
    settings.mesh_progress = show_meshes();
    return settings;
}

}  // namespace

std::uint32_t Timing::steps() const {
    return static_cast<std::uint32_t>(std::max(1L, std::lround(seconds / dt)));
}

ClosedLoop simulate(const scenes::SceneSetup& scene, scenes::Method method, const Settings& rays,
                    Timing timing, int threads) {
    scenes::Simulation simulation(scene, method, settings_of(rays, threads));
    ClosedLoop loop{scenes::start_recording(scene, timing.dt), {}};
    Progress progress("simulating " + scene.name, timing.steps());
    for (std::uint32_t i = 0; i < timing.steps(); ++i) {
        loop.log.add(simulation.step(timing.dt, loop.recording));
        progress.show(i + 1);
    }
    return loop;
}

FrameLog watch(const scenes::SceneSetup& scene, const scenes::Recording& recording,
               scenes::Method method, const Settings& rays, int threads) {
    const auto detector = scenes::make_detector(scene, method, settings_of(rays, threads));
    FrameLog log;
    Progress progress("watching " + scene.name, recording.frame_count);
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        scenes::put_frame(*detector, recording, f);
        log.add(detector->detect());
        progress.show(f + 1);
    }
    return log;
}

}  // namespace pierce::app
