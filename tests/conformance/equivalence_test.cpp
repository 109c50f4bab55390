// Every backend gives the reference's contact list, bit for bit, on every frame of the scenes.
#include <gtest/gtest.h>

#include <algorithm>

#include "pierce/contact_hash.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/recording/recording.hpp"
#include "scenes/simulate/simulation.hpp"
#include "support/backends.hpp"
#include "support/random.hpp"

namespace pierce {
namespace {

using namespace scenes;

constexpr double dt = 1.0 / 60;

struct Case {
    const char* scene;
    bool soft;
    bool as_vertices;  ///< rigid motion given vertex by vertex
};

void PrintTo(const Case& tested, std::ostream* os) { *os << tested.scene; }

class EquivalenceTest : public testing::TestWithParam<Case> {};

Recording record(const Case& wanted) {
    const SceneSetup scene = make_scene(wanted.scene, {12, wanted.soft, 3});
    Simulation simulation(scene, Method::rays, {"embree", 1});
    Recording recording = start_recording(scene, dt);
    for (int i = 0; i < 150; ++i) {
        simulation.step(dt);
        if (i % 10 == 9) simulation.record(recording);
    }
    return wanted.as_vertices ? as_deforming(recording) : recording;
}

std::vector<std::uint64_t> hashes(const Recording& recording, const RaySettings& settings,
                                  std::uint32_t& contacts) {
    const auto detector = make_detector(scene_of(recording), Method::rays, settings);
    std::vector<std::uint64_t> result;
    contacts = 0;
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        put_frame(*detector, recording, f);
        const FrameResult frame = detector->detect();
        contacts += frame.contacts;
        result.push_back(frame.hash);
    }
    return result;
}

TEST_P(EquivalenceTest, BackendsAndThreadCountsAgree) {
    const Recording recording = record(GetParam());
    for (const Settings& settings :
         {vertex_rays, Settings{}, Settings{.coverage = Coverage::complete, .reproject = false},
          Settings{.coverage = Coverage::complete}}) {
        SCOPED_TRACE(testing::Message() << "coverage " << static_cast<int>(settings.coverage)
                                        << ", reproject " << settings.reproject);
        std::uint32_t expected_contacts = 0, contacts = 0;
        const auto expected = hashes(recording, {"reference", 1, settings}, expected_contacts);
        EXPECT_GT(expected_contacts, 100u);
        EXPECT_EQ(hashes(recording, {"bvh", 1, settings}, contacts), expected);
        if (test::has_backend("cuda")) {
            EXPECT_EQ(hashes(recording, {"cuda", 1, settings}, contacts), expected);
        }
        for (int threads : {1, 2, 5}) {
            EXPECT_EQ(hashes(recording, {"embree", threads, settings}, contacts), expected)
                << threads << " threads";
            EXPECT_EQ(contacts, expected_contacts);
        }
    }
}

/// Frames follow each other as in a simulation, so that there is much to remember.
Recording record_every_step(const Case& wanted) {
    const SceneSetup scene = make_scene(wanted.scene, {6, wanted.soft, 3});
    Simulation simulation(scene, Method::rays, {"embree", 1});
    Recording recording = start_recording(scene, dt);
    for (int i = 0; i < 110; ++i) {
        simulation.step(dt);
        if (i >= 80) simulation.record(recording);
    }
    return wanted.as_vertices ? as_deforming(recording) : recording;
}

TEST_P(EquivalenceTest, BackendsAgreeWhateverRaysRemember) {
    const Recording recording = record_every_step(GetParam());
    std::vector<std::uint64_t> without_memory;
    for (const Settings& settings :
         {Settings{.temporal = Temporal::off}, Settings{.temporal = Temporal::certified},
          Settings{.temporal = Temporal::certified, .may_rest = false},
          Settings{.temporal = Temporal::paper, .predict = false},
          Settings{.temporal = Temporal::paper, .predict = true},
          Settings{.temporal = Temporal::paper, .predict = true, .full_every = 3}}) {
        SCOPED_TRACE(testing::Message()
                     << "temporal " << static_cast<int>(settings.temporal) << ", predict "
                     << settings.predict << ", full every " << settings.full_every);
        std::uint32_t expected_contacts = 0, contacts = 0;
        const auto expected = hashes(recording, {"reference", 1, settings}, expected_contacts);
        EXPECT_GT(expected_contacts, 100u);
        if (settings.temporal == Temporal::off) without_memory = expected;
        if (settings.temporal == Temporal::certified) {
            EXPECT_EQ(expected, without_memory);
        }
        EXPECT_EQ(hashes(recording, {"bvh", 1, settings}, contacts), expected);
        if (test::has_backend("cuda")) {
            EXPECT_EQ(hashes(recording, {"cuda", 1, settings}, contacts), expected);
        }
        for (int threads : {1, 3}) {
            EXPECT_EQ(hashes(recording, {"embree", threads, settings}, contacts), expected)
                << threads << " threads";
            EXPECT_EQ(contacts, expected_contacts);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, EquivalenceTest,
    testing::Values(Case{"tori", false, false}, Case{"tori", false, true},
                    Case{"tori", true, false}, Case{"bunnies", false, false},
                    Case{"bunnies", true, false}, Case{"cloth-capsule", true, false},
                    Case{"cloth-fold", true, false}, Case{"cloth-catch", true, false},
                    Case{"cloth-twist", true, false}, Case{"ball-squash", true, false}),
    [](const testing::TestParamInfo<Case>& tested) {
        std::string scene = tested.param.scene;
        std::ranges::replace(scene, '-', '_');
        return scene + (tested.param.soft ? "_soft" : "_rigid") +
               (tested.param.as_vertices ? "_as_vertices" : "");
    });

/// Meshes that coincide: every ray meets vertices and edges, and every hit is a tie.
TEST(TieTest, BackendsAgreeOnCoincidentMeshes) {
    test::Random random(31);
    SCOPED_TRACE("seed " + std::to_string(random.seed()));
    std::size_t seen = 0;
    for (int i = 0; i < 40; ++i) {
        const MeshData mesh = test::random_closed_mesh(random);
        // Shifts by sums of vertex differences put vertices on vertices and edges on edges.
        const auto vertex = [&] {
            return to_double(mesh.positions[static_cast<std::size_t>(
                random.integer(0, static_cast<int>(mesh.positions.size()) - 1))]);
        };
        const Vec3d shift = i % 3 == 0 ? Vec3d{} : vertex() - vertex();
        std::vector<std::uint64_t> found;
        for (const test::NamedBackend& backend : test::backends()) {
            World world(backend.make(),
                        {.coverage = i % 2 == 0 ? Coverage::complete : Coverage::vertices});
            const MeshId id = world.add_mesh("mesh", mesh);
            world.add_rigid_body(id);
            world.add_rigid_body(id, {shift, {}});
            world.add_deforming_body(id, test::placed(mesh, {shift, {}}));
            world.detect();
            seen += world.contacts().size();
            found.push_back(contact_hash(world.contacts()));
        }
        for (std::uint64_t hash : found) EXPECT_EQ(hash, found[0]) << "mesh " << i;
    }
    EXPECT_GT(seen, 1000u);
}

/// Boxes that share faces, edges, corners and halves of them, turned every way, facing outward or
/// inward.
TEST(TieTest, BackendsAgreeOnBoxesOnAGrid) {
    MeshData box;
    for (int k = 0; k < 8; ++k)
        box.positions.push_back({k & 1 ? 1.f : 0.f, k & 2 ? 1.f : 0.f, k & 4 ? 1.f : 0.f});
    box.triangles = {{{0, 2, 3}}, {{0, 3, 1}}, {{4, 5, 7}}, {{4, 7, 6}}, {{0, 1, 5}}, {{0, 5, 4}},
                     {{2, 6, 7}}, {{2, 7, 3}}, {{0, 4, 6}}, {{0, 6, 2}}, {{1, 3, 7}}, {{1, 7, 5}}};
    MeshData flipped = box;
    for (Triangle& t : flipped.triangles) std::swap(t.vertex[1], t.vertex[2]);
    constexpr Quaternion turns[] = {{0, 0, 0, 1}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    std::size_t seen = 0;
    for (const MeshData& mesh : {box, flipped}) {
        std::vector<World> worlds;
        std::vector<BodyId> moving;
        for (const test::NamedBackend& backend : test::backends()) {
            worlds.emplace_back(backend.make(), Settings{.coverage = Coverage::complete});
            const MeshId id = worlds.back().add_mesh("box", mesh);
            worlds.back().add_fixed_body(id);
            moving.push_back(worlds.back().add_rigid_body(id));
        }
        for (const Quaternion& turn : turns)
            for (int place = 0; place < 125; ++place) {
                const Pose pose{
                    {place % 5 * 0.5 - 1, place / 5 % 5 * 0.5 - 1, place / 25 * 0.5 - 1}, turn};
                std::vector<std::uint64_t> found;
                for (std::size_t w = 0; w < worlds.size(); ++w) {
                    worlds[w].set_pose(moving[w], pose);
                    worlds[w].detect();
                    seen += worlds[w].contacts().size();
                    found.push_back(contact_hash(worlds[w].contacts()));
                }
                for (std::uint64_t hash : found) ASSERT_EQ(hash, found[0]) << "place " << place;
            }
    }
    EXPECT_GT(seen, 1000u);
}

}  // namespace
}  // namespace pierce
