// A sheet and a soft solid that tear: in every frame, the contacts are those of a new world into
// which the torn meshes are loaded.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "pierce/contact_hash.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/world.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/simulate/simulation.hpp"
#include "support/backends.hpp"

namespace pierce {
namespace {

class TornBodiesTest : public testing::TestWithParam<test::NamedBackend> {};

const scenes::Recording& torn() {
    static const scenes::Recording recording = [] {
        const scenes::SceneSetup scene = scenes::make_scene("tear", {.nodes = 16});
        scenes::Simulation simulation(scene, scenes::Method::rays);
        scenes::Recording frames = scenes::start_recording(scene, scene.dt);
        for (double time = 0; time < 4.5; time += scene.dt) {
            simulation.step(scene.dt);
            simulation.record(frames);
        }
        return frames;
    }();
    return recording;
}

/// Contacts that do not depend on earlier steps: those of solids, and with `sheets` all of a sheet
/// that remembers nothing.
std::uint64_t hash_of(const World& world, bool sheets) {
    std::vector<Contact> kept;
    for (const Contact& c : world.contacts())
        if (sheets || !c.of_sheet) kept.push_back(c);
    return contact_hash(kept);
}

TEST_P(TornBodiesTest, ContactsAreThoseOfMeshesThatAreLoadedAnew) {
    const scenes::Recording& recording = torn();
    const scenes::SceneSetup scene = scene_of(recording);
    const auto detector = make_detector(scene, GetParam().make(), {});
    std::uint32_t changes = 0;
    std::uint64_t of_sheets = 0, of_solids = 0;
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        put_frame(*detector, recording, f);
        detector->detect();
        bool sheet_is_new = f == 0, is_new = false;
        for (const scenes::RecordedBody& body : recording.bodies)
            for (const scenes::RecordedMeshChange& change : body.mesh_changes) {
                if (change.frame != f) continue;
                is_new = true;
                ++changes;
                sheet_is_new = sheet_is_new || body.collision.sheet;
            }
        // Every third change is enough, as a new world takes most of the time.
        if ((!is_new || changes % 3 != 0) && f % 16 != 0) continue;

        World fresh(embree_backend());
        for (std::uint32_t b = 0; b < recording.bodies.size(); ++b) {
            const scenes::RecordedBody& body = recording.bodies[b];
            const std::uint32_t number = recording.mesh_of(b, f);
            const MeshId mesh = fresh.add_mesh("fresh", recording.meshes[number].data,
                                               {.inside = inside_of(recording, number)});
            if (body.motion != Motion::deforming) {
                fresh.add_fixed_body(mesh, recording.pose(b, f));
                continue;
            }
            const BodyId id = fresh.add_deforming_body(mesh, recording.positions(b, f));
            fresh.set_collision(id, body.collision);
            const std::uint32_t before = f == 0 ? 0 : f - 1;
            fresh.set_motion(id, recording.start_positions(b, before, f),
                             recording.positions(b, f));
        }
        fresh.detect();
        for (const Contact& c : fresh.contacts()) ++(c.of_sheet ? of_sheets : of_solids);
        const World& world = *detector->world();
        ASSERT_EQ(hash_of(world, sheet_is_new), hash_of(fresh, sheet_is_new))
            << "frame " << f << ": " << world.contacts().size() << " contacts and "
            << fresh.contacts().size();
    }
    EXPECT_GE(changes, 100u);
    EXPECT_GT(of_sheets, 500u);
    EXPECT_GT(of_solids, 20u);
}

INSTANTIATE_TEST_SUITE_P(Backends, TornBodiesTest, testing::ValuesIn(test::backends()),
                         test::backend_name);

}  // namespace
}  // namespace pierce
