// Detection per frame on a recorded pile of 100 tori: rays on rigid and on deforming bodies against
// Bullet's GImpact and GJK/EPA, on the same frames in one run. Colliding pairs stand beside every
// time: what each method finds.
//   pierce_bench --benchmark_repetitions=5 --benchmark_enable_random_interleaving=true
#include <benchmark/benchmark.h>

#include "scenes/detect/detector.hpp"
#include "scenes/recording/recording.hpp"
#include "scenes/simulate/simulation.hpp"

namespace {

using namespace pierce;
using namespace pierce::scenes;

constexpr double dt = 1.0 / 60;
constexpr int falling_steps = 400;  // until the pile has formed
constexpr int pile_steps = 100;

/// The pile: simulated once with rays, from its fall to near rest.
const Recording& pile(bool deforming) {
    static const Recording rigid = [] {
        const SceneSetup scene = make_scene("tori");
        Simulation simulation(scene, Method::rays);
        Recording recording = start_recording(scene, dt);
        for (int i = 0; i < falling_steps; ++i) simulation.step(dt);
        for (int i = 0; i < pile_steps; ++i) {
            simulation.record(recording);
            simulation.step(dt);
        }
        return recording;
    }();
    static const Recording soft = as_deforming(rigid);
    return deforming ? soft : rigid;
}

void detect(benchmark::State& state, Method method, bool deforming, int threads,
            Temporal temporal = Temporal::off) {
    const Recording& recording = pile(deforming);
    SceneSetup scene = scene_of(recording);
    scene.meshes = make_scene("tori").meshes;  // with convex pieces
    Settings settings = vertex_rays;
    settings.temporal = temporal;
    const auto detector = make_detector(scene, method, {"embree", threads, settings});
    std::uint32_t frame = 0;
    double pairs = 0, contacts = 0, update = 0, milliseconds = 0;
    for (auto _ : state) {
        put_frame(*detector, recording, frame);
        const FrameResult result = detector->detect();
        state.SetIterationTime(1e-3 * result.total_ms);
        pairs += static_cast<double>(result.touching.size());
        contacts += result.contacts;
        update += result.update_ms;
        milliseconds += result.total_ms;
        frame = (frame + 1) % recording.frame_count;
    }
    const auto n = static_cast<double>(state.iterations());
    state.counters["pairs"] = pairs / n;
    state.counters["contacts"] = contacts / n;
    state.counters["update_ms"] = update / n;
    state.counters["ms"] = milliseconds / n;
}

}  // namespace

// Each case sees every frame of the pile once a repetition.
#define PIERCE_CASE(name, ...)                   \
    BENCHMARK_CAPTURE(detect, name, __VA_ARGS__) \
        ->UseManualTime()                        \
        ->Unit(benchmark::kMillisecond)          \
        ->Iterations(pile_steps)

PIERCE_CASE(gimpact_rigid, Method::gimpact, false, 1);
PIERCE_CASE(rays_rigid_1_thread, Method::rays, false, 1);
PIERCE_CASE(rays_rigid_2_threads, Method::rays, false, 2);
PIERCE_CASE(rays_deforming_1_thread, Method::rays, true, 1);
PIERCE_CASE(rays_deforming_2_threads, Method::rays, true, 2);
PIERCE_CASE(rays_rigid_certified_1_thread, Method::rays, false, 1, Temporal::certified);
PIERCE_CASE(rays_rigid_certified_2_threads, Method::rays, false, 2, Temporal::certified);
PIERCE_CASE(rays_deforming_certified_1_thread, Method::rays, true, 1, Temporal::certified);
PIERCE_CASE(rays_deforming_certified_2_threads, Method::rays, true, 2, Temporal::certified);
PIERCE_CASE(gjk_epa_rigid, Method::gjk_epa, false, 1);
PIERCE_CASE(gjk_hull_rigid, Method::gjk_hull, false, 1);

BENCHMARK_MAIN();
