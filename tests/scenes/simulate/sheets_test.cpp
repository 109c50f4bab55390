// Simulated sheets: from one recorded frame to the next they go neither through themselves nor
// through anything else.
#include <gtest/gtest.h>

#include "pierce/embree_backend.hpp"
#include "pierce/world.hpp"
#include "scenes/named/layers.hpp"
#include "scenes/recording/recording.hpp"
#include "scenes/simulate/sheet_crossings.hpp"
#include "scenes/simulate/simulation.hpp"

namespace pierce::scenes {
namespace {

constexpr double dt = 1.0 / 60;

std::vector<Vec3f> obstacle_positions(const Recording& recording, std::uint32_t body,
                                      std::uint32_t frame) {
    const Frame place = frame_of(recording.pose(body, frame));
    std::vector<Vec3f> positions;
    for (Vec3f p : recording.meshes[recording.bodies[body].mesh].data.positions)
        positions.push_back(to_float(place.to_parent(to_double(p))));
    return positions;
}

/// A world of its own sees every step for the first time, so it remembers nothing.
std::uint32_t crossings_between(const Recording& recording, std::uint32_t frame) {
    World world(embree_backend(1));
    for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
        const RecordedBody& body = recording.bodies[b];
        const MeshId mesh = world.add_mesh(body.name, recording.meshes[body.mesh].data);
        if (body.motion != Motion::deforming) {
            world.set_motion(world.add_fixed_body(mesh), recording.pose(b, frame),
                             recording.pose(b, frame + 1));
            continue;
        }
        const BodyId id = world.add_deforming_body(mesh);
        // Without thickness: only what meets.
        world.set_collision(id, {SelfCollision::on, true, 0});
        world.set_motion(id, recording.positions(b, frame), recording.positions(b, frame + 1));
    }
    return world.detect().crossings;
}

Recording simulate(const SceneSetup& scene, double seconds, FrameResult& worst) {
    Simulation simulation(scene, Method::rays);
    Recording recording = start_recording(scene, dt);
    simulation.record(recording);
    for (int i = 0; i < seconds / dt; ++i) {
        const FrameResult& frame = simulation.step(dt);
        simulation.record(recording);
        worst.contacts += frame.contacts;
        worst.pulled_back += frame.pulled_back;
        worst.crossings_left += frame.crossings_left;
        worst.self_crossings += frame.self_crossings;
        worst.self_penetration = std::max(worst.self_penetration, frame.self_penetration);
    }
    return recording;
}

struct Run {
    const char* scene;
    std::uint32_t nodes;
    double seconds;
};

class SimulatedSheets : public testing::TestWithParam<Run> {};

TEST_P(SimulatedSheets, NeverCrossAnything) {
    const SceneSetup scene = make_scene(GetParam().scene, {.nodes = GetParam().nodes});
    FrameResult all;
    const Recording recording = simulate(scene, GetParam().seconds, all);
    EXPECT_GT(all.contacts, 0u);
    EXPECT_EQ(all.self_crossings, 0u);
    EXPECT_EQ(all.self_penetration, 0);
    EXPECT_EQ(all.crossings_left, 0u);
    for (std::uint32_t f = 0; f < recording.frame_count; ++f)
        for (std::uint32_t a = 0; a < recording.bodies.size(); ++a) {
            if (recording.bodies[a].motion != Motion::deforming) continue;
            const auto& triangles = scene.meshes[scene.bodies[a].mesh].data.triangles;
            for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
                if (recording.bodies[b].motion == Motion::deforming) continue;
                const auto found = crossings(triangles, recording.positions(a, f),
                                             scene.meshes[scene.bodies[b].mesh].data.triangles,
                                             obstacle_positions(recording, b, f));
                ASSERT_EQ(found.count, 0u) << "frame " << f << ", " << scene.bodies[b].name;
            }
        }
    for (std::uint32_t f = 0; f + 1 < recording.frame_count; ++f)
        ASSERT_EQ(crossings_between(recording, f), 0u) << "from frame " << f;
}

INSTANTIATE_TEST_SUITE_P(Scenes, SimulatedSheets,
                         testing::Values(Run{"cloth-capsule", 14, 2.5}, Run{"cloth-fold", 12, 3},
                                         Run{"cloth-catch", 12, 1.5}, Run{"cloth-twist", 14, 5}),
                         [](const auto& run) {
                             std::string name = run.param.scene;
                             std::erase(name, '-');
                             return name;
                         });

TEST(SheetScenes, ASheetThatIsHeldCatchesSolidsAndKeepsItsSize) {
    const SceneSetup scene = make_scene("cloth-catch", {});
    Simulation simulation(scene, Method::rays);
    for (int i = 0; i < 4 / scene.dt; ++i) EXPECT_EQ(simulation.step(scene.dt).crossings_left, 0u);
    double lowest = 9, highest = 0;
    for (std::uint32_t b = 0; b < scene.bodies.size(); ++b)
        if (scene.bodies[b].motion == Motion::rigid)
            for (std::uint32_t v = 0; v < scene.meshes[scene.bodies[b].mesh].data.positions.size();
                 ++v) {
                lowest = std::min(lowest, simulation.vertex_position(b, v).z);
                highest = std::max(highest, simulation.vertex_position(b, v).z);
            }
    EXPECT_GT(lowest, 0.5) << "the sheet carries them, far above the ground";
    EXPECT_LT(highest, 2.5);
    EXPECT_LT(simulation.kinetic_energy_per_mass(), 0.05);
    const auto sheet = static_cast<std::uint32_t>(scene.bodies.size() - 1);
    double longest = 0;
    const MeshData& mesh = scene.meshes[scene.bodies[sheet].mesh].data;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t v = t.vertex[k], w = t.vertex[(k + 1) % 3];
            longest = std::max(
                longest, length(simulation.vertex_position(sheet, v) -
                                simulation.vertex_position(sheet, w)) /
                             length(to_double(mesh.positions[v]) - to_double(mesh.positions[w])));
        }
    EXPECT_LT(longest, 2) << "its links do not creep";
}

TEST(SheetScenes, ABallIsPressedUntilItMeetsItself) {
    Simulation simulation(make_scene("ball-squash"), Method::rays);
    std::uint32_t meetings = 0;
    for (int i = 0; i < 2.5 / dt; ++i) {
        simulation.step(dt);
        for (const Contact& c : simulation.world()->contacts()) {
            if (c.a != c.b) continue;
            EXPECT_EQ(c.found, Found::self);
            ++meetings;
        }
    }
    EXPECT_GT(meetings, 0u);
}

TEST(SheetScenes, LayersComeCloseAndNeverMeet) {
    const Layers full;
    EXPECT_EQ(full.sheets * full.triangle_count(), 475000u);
    Layers layers = layers_with(8);
    layers.sheets = 6;
    Simulation simulation(layers.scene(), Method::rays);
    for (int i = 0; i < 60; ++i) {
        const FrameResult& frame = simulation.step(dt);
        EXPECT_GT(frame.contacts, 0u) << "neighbours come closer than their thickness";
        EXPECT_EQ(frame.crossings + frame.remembered + frame.tangled, 0u);
    }
    const auto
        triangles = simulation.world()->mesh(simulation.world()->mesh_of({0, 1})).triangles();
    std::vector<Vec3f> at(layers.vertex_count());
    layers.positions(3, 1, at);
    for (std::uint32_t v = 0; v < at.size(); ++v)
        EXPECT_EQ(to_float(simulation.vertex_position(3, v)), at[v]) << "the formula is the motion";
    EXPECT_EQ(self_crossings(triangles, at).count, 0u);
}

TEST(SheetScenes, RecordingsKeepWhatIsASheet) {
    const SceneSetup scene = make_scene("cloth-capsule", {.nodes = 4});
    EXPECT_EQ(scene_of([&] {
                  Recording recording = start_recording(scene, dt);
                  Simulation(scene, Method::rays).record(recording);
                  return recording;
              }())
                  .bodies[2]
                  .collision,
              scene.bodies[2].collision);
}

}  // namespace
}  // namespace pierce::scenes
