// pierce explain: what it prints and writes is what the library says, and what cannot be asked is
// refused.
#include <gmock/gmock.h>

#include "pierce/world.hpp"
#include "scenes/files/mesh_io.hpp"
#include "scenes/named/shapes.hpp"
#include "scenes/recording/recording.hpp"
#include "support/command.hpp"

namespace pierce::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

class ExplainCommandTest : public AppTest {
protected:
    ExplainCommandTest() {
        scenes::SceneSetup scene{"sample",
                                 {{"ring", scenes::torus(1, 0.3, 24, 12), {}},
                                  {"cube", scenes::box({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}), {}}},
                                 {}};
        scene.bodies = {{"ring", 0, Motion::fixed, {}, false},
                        {"in the hole", 1, Motion::rigid, {}, false},
                        {"in the ring", 1, Motion::rigid, {}, false}};
        motion = scenes::start_recording(scene, 0.01);
        motion.frame_count = 4;
        for (std::uint32_t f = 0; f < motion.frame_count; ++f) {
            const auto height = 0.01f * static_cast<float>(f);
            motion.bodies[0].values.insert(motion.bodies[0].values.end(), {0, 0, 0, 0, 0, 0, 1});
            motion.bodies[1].values.insert(motion.bodies[1].values.end(),
                                           {0.2f, 0, height, 0, 0, 0, 1});
            motion.bodies[2].values.insert(motion.bodies[2].values.end(),
                                           {0.7f, 0, height, 0, 0, 0, 1});
        }
        write_recording(motion, folder / "motion");
    }

    std::string ask(const std::string& how) const {
        return "explain " + path("motion") + " " + how;
    }

    scenes::Recording motion;
};

/// A text file, line by line.
std::vector<std::string> lines_of(const fs::path& file) {
    std::vector<std::string> lines;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

TEST_F(ExplainCommandTest, PrintsWhatItsPageShows) {
    const fs::path source = PIERCE_SOURCE_FOLDER;
    const std::string prompt = "$ pierce ";
    const std::vector<std::string> lines = lines_of(source / "docs" / "explain.md");
    int examples = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (!lines[i].starts_with(prompt)) continue;
        std::string shown;
        for (std::size_t k = i + 1;
             k < lines.size() && !lines[k].starts_with("```") && !lines[k].empty(); ++k)
            shown += lines[k] + "\n";
        const Outcome outcome = pierce(lines[i].substr(prompt.size()), source.string());
        EXPECT_EQ(outcome.code, 0);
        EXPECT_EQ(outcome.text, shown) << lines[i];
        ++examples;
    }
    EXPECT_GE(examples, 4);
}

TEST_F(ExplainCommandTest, SaysOfMeshesWhatTheLibrarySays) {
    scenes::write_obj(path("floor.obj"), scenes::box({-4, -4, -1}, {4, 4, 0}));
    scenes::write_obj(path("cube.obj"), scenes::box({0.1, 0.1, -0.1}, {1.1, 1.1, 0.9}));
    World world;
    const BodyId floor = world.add_rigid_body(
        world.add_mesh("floor", scenes::box({-4, -4, -1}, {4, 4, 0})));
    const BodyId cube = world.add_rigid_body(
        world.add_mesh("cube", scenes::box({0.1, 0.1, -0.1}, {1.1, 1.1, 0.9})));
    world.detect();
    const std::string files = path("floor.obj") + " " + path("cube.obj") + " --json " +
                              path("explain.json");
    for (std::uint32_t v = 0; v < 8; ++v) {
        const std::string number = std::to_string(v);
        const Outcome of_cube = pierce("explain " + files + " --of b --vertex " + number);
        EXPECT_EQ(of_cube.code, 0);
        EXPECT_THAT(of_cube.text, HasSubstr("vertex " + number + " of " + path("cube.obj")));
        EXPECT_THAT(of_cube.text, HasSubstr(world.explain(cube, floor, v).text()));
        for (const char* of : {"", " --of a"}) {
            const Outcome of_floor = pierce("explain " + files + " --vertex " + number + of);
            EXPECT_THAT(of_floor.text, HasSubstr("vertex " + number + " of " + path("floor.obj")));
            EXPECT_THAT(of_floor.text, HasSubstr(world.explain(floor, cube, v).text()));
        }
    }
    ASSERT_EQ(pierce("explain " + files + " --of b --vertex 1").code, 0);
    const json written = read("explain.json");
    EXPECT_EQ(written["settings"]["of"], "b");
    EXPECT_EQ(written["settings"]["vertex"], 1);
    EXPECT_EQ(written["settings"]["temporal"], "certified");
    EXPECT_NEAR(written["position"][0].get<double>(), 1.1, 1e-6);
    const json& explanation = written["explanation"];
    const Explanation expected = world.explain(cube, floor, 1);
    ASSERT_TRUE(expected.contact);
    EXPECT_EQ(explanation["reason"], "contact");
    EXPECT_EQ(explanation["text"], expected.text());
    EXPECT_EQ(explanation["t"], expected.t);
    EXPECT_EQ(explanation["own_exit"], expected.own_exit);
    EXPECT_EQ(explanation["triangle"], expected.triangle);
    EXPECT_EQ(explanation["contact"]["source"], "b");
    EXPECT_EQ(explanation["contact"]["distance"], expected.contact->distance);
    EXPECT_EQ(explanation["certificate"], nullptr);
    ASSERT_EQ(pierce("explain " + files + " --of b --vertex 7").code, 0);
    EXPECT_EQ(read("explain.json")["explanation"]["reason"], "outside_box");
    EXPECT_NEAR(read("explain.json")["explanation"]["distance"].get<double>(), 0.9, 1e-6);
    EXPECT_EQ(read("explain.json")["explanation"]["contact"], nullptr);
}

TEST_F(ExplainCommandTest, ReplaysRecordingsUpToTheFrame) {
    World world;
    const MeshId ring = world.add_mesh("ring", motion.meshes[0].data),
                 cube = world.add_mesh("cube", motion.meshes[1].data);
    const BodyId body[] = {world.add_fixed_body(ring), world.add_rigid_body(cube),
                           world.add_rigid_body(cube)};
    double left[4] = {};
    for (std::uint32_t f = 0; f < motion.frame_count; ++f) {
        for (std::uint32_t b = 0; b < 3; ++b) world.set_pose(body[b], motion.pose(b, f));
        world.detect();
        for (std::uint32_t b : {1u, 2u})
            for (std::uint32_t v : {0u, 7u}) {
                const std::string which = "--frame " + std::to_string(f) + " --vertex " +
                                          std::to_string(v) + " --bodies " + std::to_string(b) +
                                          " 0 --json " + path("explain.json");
                const Outcome outcome = pierce(ask(which));
                ASSERT_EQ(outcome.code, 0) << outcome.text;
                EXPECT_THAT(outcome.text, HasSubstr(world.explain(body[b], body[0], v).text()))
                    << which;
                if (b == 1 && v == 0)
                    left[f] = read("explain.json")["explanation"]["certificate"]["left"];
            }
    }
    EXPECT_NEAR(left[3], left[0] - 0.03, 1e-5) << "the certificate is the first frame's";
    EXPECT_EQ(read("explain.json")["settings"]["frame"], 3);
    EXPECT_EQ(read("explain.json")["settings"]["bodies"], (json{2, 0}));
    EXPECT_EQ(read("explain.json")["explanation"]["reason"], "contact");
    EXPECT_THAT(pierce(ask("--frame 1 --bodies 1 0 --vertex 2")).text,
                HasSubstr("vertex 2 of body 1 'in the hole', at "));
    ASSERT_EQ(
        pierce(ask("--frame 3 --bodies 1 0 --vertex 0 --temporal off --json " + path("off.json")))
            .code,
        0);
    EXPECT_EQ(read("off.json")["explanation"]["certificate"], nullptr);
    EXPECT_EQ(read("off.json")["settings"]["temporal"], "off");
}

TEST_F(ExplainCommandTest, KnowsVerticesThatAMeshGetsLater) {
    scenes::Recording grows = motion;
    scenes::RecordedBody& body = grows.bodies[2];
    body.motion = Motion::deforming;
    body.mesh_changes = {{2, 0}};
    body.values.clear();
    for (std::uint32_t f = 0; f < grows.frame_count; ++f)
        for (Vec3f p : grows.meshes[grows.mesh_of(2, f)].data.positions)
            body.values.insert(body.values.end(), {p.x + 0.7f, p.y, p.z});
    write_recording(grows, folder / "motion");
    const Outcome later = pierce(ask("--vertex 200 --frame 2 --bodies 2 0"));
    EXPECT_EQ(later.code, 0) << later.text;
    EXPECT_THAT(later.text, HasSubstr("vertex 200 of body 2"));
    expect_refused(ask("--vertex 200 --frame 1 --bodies 2 0"), "mesh 'cube' has no vertex 200");
    expect_refused(ask("--vertex 288 --frame 2 --bodies 2 0"), "mesh 'ring' has no vertex 288");
}

TEST_F(ExplainCommandTest, RefusesWhatCannotBeAsked) {
    scenes::write_obj(path("cube.obj"), scenes::box({0, 0, 0}, {1, 1, 1}));
    const std::string cube = path("cube.obj"), two = "explain " + cube + " " + cube;
    expect_refused("explain", "inputs");
    expect_refused(two, "--vertex");
    expect_refused(two + " --vertex -1", "--vertex");
    expect_refused(two + " --vertex 8", "cube.obj' has no vertex 8");
    expect_refused(two + " --vertex 0 --of c", "--of");
    expect_refused(two + " --vertex 0 --frame 1", "--frame and --bodies are for recordings");
    expect_refused(two + " --vertex 0 --bodies 0 1", "--frame and --bodies are for recordings");
    expect_refused(two + " --vertex 0 --backend optix", "unknown backend 'optix'");
    expect_refused(two + " --vertex 0 --coverage most", "--coverage");
    expect_refused(two + " --vertex 0 --json /nowhere/x.json", "/nowhere/x.json");
    expect_refused(two + " " + cube + " --vertex 0", "inputs: At Most 2");
    expect_refused("explain " + cube + " " + path("nothing.obj") + " --vertex 0", "nothing.obj");
    expect_refused("explain " + cube + " --vertex 0", "cube.obj' is one file");
    expect_refused("explain " + path("nothing") + " --frame 0 --bodies 0 1 --vertex 0",
                   "nothing/scene.json");
    expect_refused(ask("--vertex 0"), "a recording needs --frame and --bodies");
    expect_refused(ask("--vertex 0 --frame 0"), "a recording needs --frame and --bodies");
    expect_refused(ask("--vertex 0 --frame 0 --bodies 1"), "--bodies");
    expect_refused(ask("--vertex 0 --frame 0 --bodies 1 0 --of a"), "--of is for meshes");
    expect_refused(ask("--vertex 0 --frame 4 --bodies 1 0"), "has frames 0 to 3, no frame 4");
    expect_refused(ask("--vertex 0 --frame 0 --bodies 1 3"), "has bodies 0 to 2, no body 3");
    expect_refused(ask("--vertex 0 --frame 0 --bodies 1 1"), "its own body");
    expect_refused(ask("--vertex 8 --frame 0 --bodies 1 0"), "mesh 'cube' has no vertex 8");
}

}  // namespace
}  // namespace pierce::test
