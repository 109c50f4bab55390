// What is true in a frame of a recording, and the program that writes it down.
#include "truth/frame_truth.hpp"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "truth/cubes.hpp"

namespace pierce::truth {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using scenes::box;
using scenes::torus;
using testing::HasSubstr;
using testing::IsEmpty;

using Bodies = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Ground from z = -1 to 0 and a fixed post in it; per frame a rigid and a deforming body.
class FrameTruthTest : public testing::Test {
protected:
    scenes::Recording recording{0.01, 0, {}, {}};

    std::uint32_t add_mesh(const MeshData& mesh) {
        recording.meshes.push_back({"mesh " + std::to_string(recording.meshes.size()), mesh, {}});
        return static_cast<std::uint32_t>(recording.meshes.size() - 1);
    }
    void add(std::uint32_t mesh, Motion motion, std::vector<float> values) {
        const std::string name = "body " + std::to_string(recording.bodies.size());
        recording.bodies.push_back({name, mesh, motion, false, std::move(values)});
    }

    static std::vector<float> pose(Vec3f p) { return {p.x, p.y, p.z, 0, 0, 0, 2}; }

    /// Bodies 0 to 3: ground and a post in it, both fixed; a rigid and a deforming cube, 0.25 deep
    /// in the ground.
    void add_two_cubes_on_ground() {
        add(add_mesh(box({-5, -5, -1}, {5, 5, 0})), Motion::fixed, pose({}));
        add(add_mesh(box({3, 3, -2}, {4, 4, 2})), Motion::fixed, pose({}));
        const std::uint32_t mesh = add_mesh(cube(0.5));
        add(mesh, Motion::rigid, pose({-2, 0, 0.25f}));
        std::vector<float> values;
        for (Vec3f p : cube(0.5).positions)
            values.insert(values.end(), {p.x + 2, p.y, p.z + 0.25f});
        add(mesh, Motion::deforming, values);
        recording.frame_count = 1;
    }
};

TEST_F(FrameTruthTest, CubesInTheGround) {
    add_two_cubes_on_ground();
    const FrameTruth truth = RecordingTruth(recording).at(0);
    EXPECT_EQ(truth.overlapping, (Bodies{{0, 2}, {0, 3}})) << "two fixed bodies are no pair";
    ASSERT_EQ(truth.inside.size(), 8u);
    for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_EQ(truth.inside[i].source, i < 4 ? 2u : 3u);
        EXPECT_EQ(truth.inside[i].target, 0u);
        EXPECT_LT(cube(0.5).positions[truth.inside[i].vertex].z, 0);
        EXPECT_EQ(truth.inside[i].depth, 0.25);
        EXPECT_EQ(truth.inside[i].normal, (Vec3d{0, 0, 1}));
    }
    EXPECT_THAT(RecordingTruth(recording).at(0, false).inside, IsEmpty());
    EXPECT_EQ(RecordingTruth(recording).at(0, false).overlapping, truth.overlapping);
}

TEST_F(FrameTruthTest, BodiesThatDoNotMeetAreNoPair) {
    add_two_cubes_on_ground();
    recording.bodies[2].filter.world = 1;
    EXPECT_EQ(RecordingTruth(recording).at(0).overlapping, (Bodies{{0, 2}, {0, 3}}));
    recording.bodies[0].filter.world = 2;
    EXPECT_EQ(RecordingTruth(recording).at(0).overlapping, (Bodies{{0, 3}}));
    recording.excluded = {{0, 3}};
    EXPECT_THAT(RecordingTruth(recording).at(0).overlapping, IsEmpty());
    EXPECT_THAT(RecordingTruth(recording).at(0).inside, IsEmpty());
}

TEST_F(FrameTruthTest, ACubeOnTheGroundOverlapsItWithNothingInside) {
    add(add_mesh(box({-5, -5, -1}, {5, 5, 0})), Motion::fixed, pose({}));
    add(add_mesh(cube(0.5)), Motion::rigid, pose({1, 2, 0.5f}));
    recording.frame_count = 1;
    const FrameTruth truth = RecordingTruth(recording).at(0);
    EXPECT_EQ(truth.overlapping, (Bodies{{0, 1}}));
    EXPECT_THAT(truth.inside, IsEmpty());
}

TEST_F(FrameTruthTest, NormalsAreInWorldSpace) {
    const float s = std::sqrt(0.5f);
    add(add_mesh(box({-5, -5, -1}, {5, 5, 0})), Motion::fixed, {10, 0, 0, 0, s, 0, s});  // its top
                                                                                         // faces
                                                                                         // along x
    add(add_mesh(cube(0.5)), Motion::rigid, pose({10.25f, 0, 0}));
    recording.frame_count = 1;
    const FrameTruth truth = RecordingTruth(recording).at(0);
    ASSERT_EQ(truth.inside.size(), 4u);
    for (const InsideVertex& v : truth.inside) {
        EXPECT_NEAR(v.depth, 0.25, 1e-6);
        EXPECT_NEAR(length(v.normal - Vec3d{1, 0, 0}), 0, 1e-6);
    }
}

TEST_F(FrameTruthTest, ContainedBodiesOverlapUnlessOneIsOpen) {
    const std::uint32_t big = add_mesh(cube(2)), small = add_mesh(cube(0.5)),
                        open = add_mesh(open_cube());
    recording.meshes[open].inside = Inside::none;
    add(big, Motion::rigid, pose({}));
    add(small, Motion::rigid, pose({1, 1, 1}));
    recording.frame_count = 1;
    FrameTruth truth = RecordingTruth(recording).at(0);
    EXPECT_EQ(truth.overlapping, (Bodies{{0, 1}}));
    ASSERT_EQ(truth.inside.size(), 8u);
    EXPECT_EQ(truth.inside[0].source, 1u);

    std::swap(recording.bodies[0], recording.bodies[1]);
    truth = RecordingTruth(recording).at(0);
    EXPECT_EQ(truth.overlapping, (Bodies{{0, 1}}));
    ASSERT_EQ(truth.inside.size(), 8u);
    EXPECT_EQ(truth.inside[0].source, 0u);
    std::swap(recording.bodies[0], recording.bodies[1]);

    recording.bodies[1].mesh = open;
    recording.bodies[1].values = pose({0.5f, 0.5f, 0.5f});
    truth = RecordingTruth(recording).at(0);
    EXPECT_THAT(truth.overlapping, IsEmpty());
    EXPECT_EQ(truth.inside.size(), 8u) << "an open body's vertices are inside of others";
    recording.bodies[1].mesh = small;
    recording.bodies[0].mesh = open;
    recording.bodies[1].values = pose({-1, 0, 0});
    truth = RecordingTruth(recording).at(0);
    EXPECT_EQ(truth.overlapping, (Bodies{{0, 1}}));
    EXPECT_THAT(truth.inside, IsEmpty()) << "nothing is inside an open body";
}

TEST_F(FrameTruthTest, BodiesThatAreNotFiniteAreLeftOut) {
    add_two_cubes_on_ground();
    recording.bodies[2].values[6] = 0;
    EXPECT_EQ(RecordingTruth(recording).at(0).overlapping, (Bodies{{0, 3}})) << "no rotation";
    recording.bodies[3].values[5] = NAN;
    EXPECT_THAT(RecordingTruth(recording).at(0).overlapping, IsEmpty());
}

/// The truth of a program run, as the library gives it.
json expected_json(const scenes::Recording& recording, std::uint32_t every) {
    json frames = json::array();
    for (std::uint32_t f = 0; f < recording.frame_count; f += every) {
        const FrameTruth truth = RecordingTruth(recording).at(f);
        json inside = json::array();
        for (const InsideVertex& v : truth.inside)
            inside.push_back(
                {v.source, v.target, v.vertex, v.depth, v.normal.x, v.normal.y, v.normal.z});
        frames.push_back({{"frame", f}, {"overlapping", truth.overlapping}, {"inside", inside}});
    }
    return {{"format", "pierce-truth"}, {"version", 1}, {"every", every}, {"frames", frames}};
}

struct Outcome {
    int code = -1;
    std::string text;  ///< standard output and error
};

Outcome pierce_truth(const std::string& arguments) {
    Outcome outcome;
    std::FILE* pipe = popen((std::string(PIERCE_TRUTH) + " " + arguments + " 2>&1").c_str(), "r");
    for (char buffer[4096]; const std::size_t n = std::fread(buffer, 1, sizeof buffer, pipe);)
        outcome.text.append(buffer, n);
    outcome.code = WEXITSTATUS(pclose(pipe));
    return outcome;
}

/// A recording of five frames in a folder that goes away with the test: a torus sinks into a slope.
class ProgramTest : public FrameTruthTest {
protected:
    ProgramTest()
        : folder(fs::temp_directory_path() / ("pierce_truth_" + std::to_string(::getpid()))) {
        add(add_mesh(box({-5, -5, -1}, {5, 5, 0})), Motion::fixed, {0, 0, 0, 0.1f, -0.2f, 0, 1});
        std::vector<float> values;
        for (float height : {2.f, 1.5f, 1.f, 0.5f, 0.f})
            for (float v : {0.f, 0.f, height, 0.1f, 0.2f, 0.f, 1.f}) values.push_back(v);
        add(add_mesh(torus(1, 0.25, 20, 10)), Motion::rigid, values);
        recording.frame_count = 5;
        scenes::write_recording(recording, folder);
    }
    ~ProgramTest() override { fs::remove_all(folder); }

    json read(const std::string& name) const { return json::parse(std::ifstream(folder / name)); }

    fs::path folder;
};

TEST_F(ProgramTest, WritesTheTruth) {
    const Outcome all = pierce_truth(folder.string());
    EXPECT_EQ(all.code, 0);
    EXPECT_EQ(all.text, "") << "no progress bar in a pipe";
    EXPECT_EQ(read("truth.json"), expected_json(recording, 1));
    EXPECT_THAT(read("truth.json")["frames"][0]["overlapping"], IsEmpty());
    EXPECT_GT(read("truth.json")["frames"][4]["inside"].size(), 10u);

    const std::string other = (folder / "other.json").string();
    EXPECT_EQ(pierce_truth(folder.string() + " --every 3 --out " + other).code, 0);
    EXPECT_EQ(read("other.json"), expected_json(recording, 3));
    EXPECT_EQ(pierce_truth(folder.string() + " --pairs-only --out " + other).code, 0);
    json pairs = expected_json(recording, 1);
    for (json& frame : pairs["frames"]) frame.erase("inside");
    EXPECT_EQ(read("other.json"), pairs);
}

TEST_F(ProgramTest, RefusesBadInputWithOneLineThatNamesIt) {
    const auto refused = [](const std::string& arguments, const std::string& why) {
        const Outcome outcome = pierce_truth(arguments);
        EXPECT_EQ(outcome.code, 2) << arguments;
        EXPECT_THAT(outcome.text, HasSubstr(why)) << arguments;
    };
    refused("", "folder");
    refused((folder / "nothing").string(), "cannot open");
    refused(folder.string() + " --every 0", "--every");
    refused(folder.string() + " --out " + (folder / "no" / "file.json").string(), "cannot write");
}

}  // namespace
}  // namespace pierce::truth
