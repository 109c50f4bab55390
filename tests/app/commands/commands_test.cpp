// The pierce command as its users meet it: what it prints, writes and refuses.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "support/command.hpp"

namespace pierce::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

TEST_F(AppTest, ListsScenesAndPlans) {
    EXPECT_THAT(pierce("scenes").text, testing::AllOf(HasSubstr("tori"), HasSubstr("bunnies")));
    const Outcome rigid = pierce("plan tori --count 3");
    EXPECT_EQ(rigid.code, 0);
    EXPECT_THAT(rigid.text, testing::AllOf(HasSubstr("1 fixed, 3 rigid, 0 deforming"),
                                           HasSubstr("no vertex is looked at")));
    EXPECT_THAT(pierce("plan tori --count 3 --soft").text,
                HasSubstr("one refitted tree per deforming body"));
    EXPECT_THAT(pierce("--version").text, HasSubstr("pierce 0."));
}

TEST_F(AppTest, WritesWithWhichSettingsItRan) {
    const std::string run = "run tori --count 2 --seconds 0.02 --json " + path("run.json");
    const auto settings = [&](const std::string& options) {
        EXPECT_EQ(pierce(run + options).code, 0) << options;
        return read("run.json")["settings"];
    };
    const json by_default = settings("");
    EXPECT_EQ(by_default["coverage"], "overlaps");
    EXPECT_EQ(by_default["temporal"], "certified");
    EXPECT_EQ(by_default["reproject"], true);
    for (const char* coverage : {"vertices", "overlaps", "complete"})
        EXPECT_EQ(settings(std::string(" --coverage ") + coverage)["coverage"], coverage);
    for (const char* temporal : {"off", "paper", "certified"})
        EXPECT_EQ(settings(std::string(" --temporal ") + temporal)["temporal"], temporal);
    const json others = settings(" --margin 0.25 --parts 2 --inside winding --mesh-cache " +
                                 path("cache"));
    EXPECT_EQ(others["margin"], 0.25);
    EXPECT_EQ(others["parts"], 2);
    EXPECT_EQ(others["inside"], "winding");
    EXPECT_EQ(others["mesh_cache"], path("cache"));
}

TEST_F(AppTest, ReplaysTheContactsOfARunFrameByFrame) {
    for (const char* scene : {"bunnies --count 3 --seconds 1", "tori --count 3 --seconds 1 --soft",
                              "cloth-fold --nodes 10 --seconds 1", "tear --seconds 0.5"}) {
        const std::string motion = path(scene);
        ASSERT_EQ(pierce("run " + std::string(scene) + " --record '" + motion + "' --json " +
                         path("run.json"))
                      .code,
                  0);
        ASSERT_EQ(pierce("replay '" + motion + "' --json " + path("replay.json")).code, 0);
        const json run = read("run.json")["frames"], replay = read("replay.json")["frames"];
        ASSERT_EQ(run.size(), replay.size());
        std::size_t contacts = 0;
        for (std::size_t f = 0; f < run.size(); ++f) {
            EXPECT_EQ(run[f]["hash"], replay[f]["hash"]) << scene << ", frame " << f;
            contacts += run[f]["contacts"].get<std::size_t>();
        }
        EXPECT_GT(contacts, 0u) << scene;
    }
}

TEST_F(AppTest, ReplaysAskWhatIsInsideAsTheyAreTold) {
    const auto contacts = [&](const std::string& command) {
        EXPECT_EQ(pierce(command + " --json " + path("all.json")).code, 0) << command;
        return read("all.json")["summary"]["contacts"];
    };
    const std::string run = "run tori --count 3 --seconds 1 ", replay = "replay " + path("motion");
    const json none = contacts(run + "--inside none --record " + path("motion"));
    EXPECT_EQ(contacts(replay), none) << "the recording says so";
    EXPECT_EQ(contacts(replay + " --inside closed"), none);
    const json solid = contacts(run + "--record " + path("motion"));
    EXPECT_NE(solid, none);
    EXPECT_EQ(contacts(replay), solid);
    EXPECT_NE(contacts(replay + " --inside none"), solid);
    EXPECT_EQ(contacts(replay + " --mesh-cache " + path("cache")), solid);
    EXPECT_FALSE(fs::is_empty(folder / "cache"));
}

TEST_F(AppTest, RefusesTwoFilesOfOneName) {
    const auto refused = [&](const std::string& command) {
        const Outcome outcome = pierce(command);
        EXPECT_EQ(outcome.code, 2) << command;
        EXPECT_THAT(outcome.text, HasSubstr("two files are to be written as")) << command;
    };
    refused("run tori --count 2 --seconds 0.1 --json " + path("a") + " --png " + path("./a"));
    refused("run tori --count 2 --seconds 0.1 --html " + path("a") + " --json " + path("a"));
}

TEST_F(AppTest, RefusesToReplaceWhatItReads) {
    ASSERT_EQ(pierce("run tori --count 1 --seconds 0.1 --record " + path("motion")).code, 0);
    std::ofstream(folder / "a.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                       "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    for (const std::string command :
         {"check a.obj --json ./a.obj", "check a.obj --fix a.obj",
          "detect a.obj a.obj --html a.obj", "replay motion --json motion/scene.json",
          "explain motion --vertex 0 --json motion/body_1.npy",
          "run tori --count 1 --seconds 0.1 --record motion --json motion/scene.json",
          "run tori --count 1 --seconds 0.1 --record new --png ./new/mesh_0.obj"}) {
        const Outcome outcome = pierce(command, folder);
        EXPECT_EQ(outcome.code, 2) << command;
        EXPECT_THAT(outcome.text, HasSubstr("would replace")) << command;
    }
    for (int i = 0; i < 2; ++i)
        EXPECT_EQ(pierce("replay motion --json motion/result.json", folder).code, 0);
}

TEST_F(AppTest, WritesAPictureOfEveryFrame) {
    ASSERT_EQ(pierce("run tori --count 2 --seconds 0.1 --record " + path("short")).code, 0);
    const std::string replay = "replay " + path("short") + " --json ";
    ASSERT_EQ(pierce(replay + path("plain.json")).code, 0);
    ASSERT_EQ(pierce(replay + path("drawn.json") + " --pictures " + path("pictures")).code, 0);
    const json plain = read("plain.json")["frames"], drawn = read("drawn.json")["frames"];
    ASSERT_EQ(plain.size(), 6u);
    for (std::size_t f = 0; f < plain.size(); ++f) {
        EXPECT_EQ(drawn[f]["hash"], plain[f]["hash"]) << "a picture changes no contact";
        std::ifstream png(folder / "pictures" / ("0000" + std::to_string(f) + ".png"),
                          std::ios::binary);
        char head[4] = {};
        png.read(head, 4);
        EXPECT_EQ(std::string(head + 1, 3), "PNG") << f;
    }
    expect_refused("replay " + path("short") + " --method gimpact --pictures " + path("none"),
                   "--pictures need --method rays");
}

TEST_F(AppTest, PicturesAreThoseOfTheReplayAlone) {
    ASSERT_EQ(pierce("run tori --count 2 --seconds 0.1 --record " + path("long")).code, 0);
    ASSERT_EQ(pierce("run tori --count 2 --seconds 0.05 --record " + path("short")).code, 0);
    for (const auto& [recording, frames] : {std::pair("long", 6), std::pair("short", 3)}) {
        ASSERT_EQ(pierce("replay " + path(recording) + " --pictures " + path("pictures")).code, 0);
        EXPECT_EQ(std::distance(fs::directory_iterator(folder / "pictures"), {}), frames);
    }
}

// Bodies that are left out of the last step are in no picture.
TEST_F(AppTest, APictureOfTheGroundAloneIsOne) {
    const Outcome outcome = pierce("run tori --count 2 --seconds 1e300 --dt 1e299 --png " +
                                   path("ground.png") + " --json " + path("ground.json"));
    EXPECT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_TRUE(fs::exists(folder / "ground.png"));
    EXPECT_TRUE(fs::exists(folder / "ground.json"));
}

TEST_F(AppTest, RunsRecordsAndReplaysTheSameContacts) {
    const Outcome run = pierce("run tori --count 5 --seconds 2 --record " + path("motion") +
                               " --json " + path("run.json") + " --png " + path("last.png"));
    ASSERT_EQ(run.code, 0) << run.text;
    EXPECT_THAT(run.text, testing::AllOf(HasSubstr("120 frames"), HasSubstr("vertex_cull [ms]"),
                                         HasSubstr("colliding pairs")));
    EXPECT_THAT(run.text, testing::Not(HasSubstr("left"))) << "no progress bar in a pipe";
    std::ifstream png(folder / "last.png", std::ios::binary);
    char head[4] = {};
    png.read(head, 4);
    EXPECT_EQ(std::string(head + 1, 3), "PNG");

    const json written = read("run.json");
    for (const char* key : {"machine", "versions", "settings", "summary", "frames"})
        EXPECT_TRUE(written.contains(key)) << key;
    ASSERT_EQ(written["frames"].size(), 120u);
    const json& frame = written["frames"][119];
    EXPECT_EQ(frame["index"], 119);
    EXPECT_GT(frame["ms"]["total"].get<double>(), 0);
    for (const char* stage : {"bounds", "pairs", "vertex_cull", "ray_gen", "update", "trace",
                              "classify", "contacts", "response"})
        EXPECT_TRUE(frame["ms"].contains(stage)) << stage;
    EXPECT_FALSE(frame["pairs"].empty());
    for (const json& pair : frame["pairs"]) EXPECT_LT(pair[0].get<int>(), pair[1].get<int>());

    std::set<std::string> last_hashes;
    for (const char* how : {"--threads 1", "--threads 2", "--backend reference"}) {
        ASSERT_EQ(
            pierce("replay " + path("motion") + " " + how + " --json " + path("replay.json")).code,
            0);
        const json replayed = read("replay.json");
        std::string all;
        for (const json& f : replayed["frames"]) all += f["hash"].get<std::string>();
        last_hashes.insert(all);
    }
    std::string of_run;
    for (const json& f : written["frames"]) of_run += f["hash"].get<std::string>();
    last_hashes.insert(of_run);
    EXPECT_EQ(last_hashes.size(), 1u) << "the run, threads and backends give the same contacts";
    EXPECT_FALSE(last_hashes.begin()->empty());
    for (const char* method : {"gjk-epa", "gjk-hull", "gimpact"})
        EXPECT_EQ(pierce("replay " + path("motion") + " --method " + method).code, 0) << method;
    EXPECT_EQ(pierce("replay " + path("motion") + " --deforming").code, 0);
}

TEST_F(AppTest, WhatRaysRememberIsChosenOnTheCommandLine) {
    ASSERT_EQ(pierce("run tori --count 6 --seconds 2 --record " + path("motion")).code, 0);
    const auto replay = [&](const std::string& how) {
        const Outcome outcome = pierce("replay " + path("motion") + " " + how + " --json " +
                                       path("replay.json"));
        EXPECT_EQ(outcome.code, 0) << outcome.text;
        return read("replay.json");
    };
    const auto hashes = [](const json& result) {
        std::string all;
        for (const json& f : result["frames"]) all += f["hash"].get<std::string>();
        return all;
    };
    const json off = replay("--temporal off"), certified = replay("--temporal certified"),
               paper = replay("--temporal paper --predict off --full-every 4"),
               predicting = replay("--temporal paper");
    EXPECT_EQ(hashes(off), hashes(certified));
    EXPECT_NE(hashes(off), hashes(paper)) << "the paper's mode misses some";
    EXPECT_EQ(certified["settings"]["temporal"], "certified");
    EXPECT_EQ(paper["settings"]["full_every"], 4);
    EXPECT_EQ(off["summary"]["walks"]["max"], 0);
    EXPECT_GT(paper["summary"]["walks"]["max"].get<int>(), 0);
    EXPECT_EQ(paper["summary"]["predictions"]["max"], 0);
    EXPECT_GT(predicting["summary"]["predictions"]["max"].get<int>(), 0);
    EXPECT_GT(predicting["frames"][119]["ms"]["walk"].get<double>(), 0);
    EXPECT_THAT(pierce("plan tori --temporal paper").text, HasSubstr("displacement"));
    EXPECT_THAT(pierce("plan tori --temporal off").text, testing::Not(HasSubstr("displacement")));
}

TEST_F(AppTest, DetectsContactsOfMeshFiles) {
    std::ofstream(folder / "a.off")
        << "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    std::ofstream(folder / "b.obj") << "v 0.1 0.1 0.1\nv 2 0.1 0.1\nv 0.1 2 0.1\nv 0.1 0.1 2\nf 1 "
                                       "3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    const Outcome found = pierce("detect " + path("a.off") + " " + path("b.obj") + " --json " +
                                 path("contacts.json"));
    ASSERT_EQ(found.code, 0) << found.text;
    EXPECT_THAT(found.text, HasSubstr("1 of 1 overlapping pairs"));
    const json contacts = read("contacts.json")["contacts"];
    ASSERT_FALSE(contacts.empty());
    EXPECT_EQ(contacts[0]["source"], "b");
    EXPECT_EQ(contacts[0]["vertex"], 0);
    EXPECT_LT(contacts[0]["distance"].get<double>(), 0);
}

TEST_F(AppTest, ChecksMeshes) {
    const std::string corners = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n",
                      faces = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    std::ofstream(folder / "sound.off") << "OFF\n4 4 0\n" << corners << faces;
    std::ofstream(folder / "seam.off") << "OFF\n5 4 0\n" << corners << "0 0 0\n" << faces;
    std::ofstream(folder / "open.off") << "OFF\n4 3 0\n"
                                       << corners << "3 0 2 1\n3 0 1 3\n3 0 3 2\n";
    std::ofstream(folder / "nan.off") << "OFF\n4 4 0\n0 0 0\nnan 0 0\n0 1 0\n0 0 1\n" << faces;
    std::ofstream(folder / "fold.off")
        << "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0.3 0.5 0\n3 0 1 2\n3 1 0 3\n";

    const Outcome sound = pierce("check " + path("sound.off"));
    EXPECT_EQ(sound.code, 0) << sound.text;
    EXPECT_THAT(sound.text, HasSubstr("sound, closed; 4 vertices, 4 triangles, 1 component, volume "
                                      "0.166667, size 1 x 1 x 1"));
    EXPECT_EQ(std::ranges::count(sound.text, '\n'), 1);
    const Outcome seam = pierce("check " + path("seam.off"));
    EXPECT_EQ(seam.code, 0) << "what does no harm is no failure";
    EXPECT_THAT(seam.text, HasSubstr("- duplicate vertices: 1 (vertex 4)"));

    const Outcome open = pierce("check " + path("sound.off") + " " + path("open.off"));
    EXPECT_EQ(open.code, 1);
    EXPECT_THAT(open.text, testing::AllOf(HasSubstr("! border edges: 3 (edge 1-2, 1-3, 2-3)"),
                                          HasSubstr("no inside")));
    const Outcome cut = pierce("check --fix " + path("fixed.obj") + " " + path("open.off"));
    EXPECT_EQ(cut.code, 1) << "of what was found";
    EXPECT_THAT(cut.text, HasSubstr("still open; 4 vertices (4 before), 3 triangles (3 before)"));
    std::ofstream(folder / "torn.off") << "OFF\n8 11 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n"
                                          "0 1 1\n1 1 1\n3 0 2 3\n3 0 3 1\n3 4 5 7\n3 4 7 6\n"
                                          "3 0 1 5\n3 0 5 4\n3 2 6 7\n3 2 7 3\n3 0 4 6\n3 0 6 2\n"
                                          "3 7 3 1\n";
    const Outcome torn = pierce("check --fix " + path("fixed.obj") + " " + path("torn.off"));
    EXPECT_THAT(torn.text, HasSubstr("1 hole closed by 1 triangle (9.1 % of the area)"));
    EXPECT_THAT(torn.text, HasSubstr("fixed.obj: closed; 8 vertices (8 before), 12 triangles"));
    EXPECT_EQ(pierce("check " + path("fixed.obj")).code, 0);
    EXPECT_THAT(pierce("check --inside none " + path("torn.off")).text, HasSubstr("no inside"));
    const Outcome nan = pierce("check " + path("nan.off"));
    EXPECT_EQ(nan.code, 1);
    EXPECT_THAT(nan.text, HasSubstr("vertices not finite: 1 (vertex 1)"));
    EXPECT_THAT(pierce("check " + path("fold.off")).text,
                testing::Not(HasSubstr("self-intersections")));
    EXPECT_THAT(pierce("check --self-intersections " + path("fold.off")).text,
                HasSubstr("self-intersections: 1 (triangles 0-1)"));

    const Outcome mixed = pierce("check " + path("nothing.off") + " " + path("open.off") +
                                 " --json " + path("check.json"));
    EXPECT_EQ(mixed.code, 2);
    EXPECT_THAT(mixed.text,
                testing::AllOf(HasSubstr("nothing.off: unreadable"), HasSubstr("border edges")));
    const json meshes = read("check.json")["meshes"];
    ASSERT_EQ(meshes.size(), 2u);
    EXPECT_THAT(meshes[0]["error"].get<std::string>(), HasSubstr("cannot open"));
    EXPECT_EQ(meshes[1]["sound"], false);
    EXPECT_EQ(meshes[1]["closed"], false);
    EXPECT_EQ(meshes[1]["vertices"], 4);
    EXPECT_EQ(meshes[1]["box"], json::parse("[[0, 0, 0], [1, 1, 1]]"));
    ASSERT_EQ(meshes[1]["findings"].size(), 1u);
    EXPECT_EQ(meshes[1]["findings"][0]["defect"], "border edges");
    EXPECT_EQ(meshes[1]["findings"][0]["count"], 3);
    EXPECT_EQ(meshes[1]["findings"][0]["places"], json::parse("[[1, 2], [1, 3], [2, 3]]"));
    EXPECT_EQ(meshes[1]["findings"][0]["changes_detection"], true);
}

TEST_F(AppTest, RefusesBadInputWithOneLineThatNamesIt) {
    expect_refused("run torus", "unknown scene 'torus'; there are: tori, bunnies");
    expect_refused("run tori --threads 0", "--threads");
    expect_refused("run tori --dt -0.01", "--dt");
    expect_refused("run tori --dt 0", "--dt");
    expect_refused("run tori --dt nan", "--dt");
    expect_refused("run tori --seconds -1", "--seconds");
    expect_refused("run tori --count 0", "--count");
    expect_refused("run tori --method sat",
                   "unknown method 'sat'; there are: rays, gjk-epa, gjk-hull, gimpact");
    expect_refused("run tori --backend optix",
                   "unknown backend 'optix'; there are: automatic, embree, cuda, bvh, reference");
    expect_refused("run tori --count 1 --soft --method gimpact", "soft bodies");
    expect_refused("run tori --count 1 --json /nowhere/x.json", "/nowhere/x.json");
    expect_refused("run tori --count 1 --method gimpact --png " + path("x.png"), "--png");
    expect_refused("run tori --frobnicate", "--frobnicate");
    expect_refused("run tori --temporal always", "--temporal");
    expect_refused("run tori --predict maybe", "--predict");
    expect_refused("run tori --full-every 0", "--full-every");
    for (const char* option : {"--predict on", "--full-every 4", "--temporal off --predict off"})
        expect_refused("run tori " + std::string(option), "no effect without --temporal paper");
    expect_refused("run tori --rest on --temporal paper", "--temporal certified");
    expect_refused("run tori --html-reasons off", "no effect without --html");
    for (const char* option : {"--count 7", "--soft", "--seed 2"})
        expect_refused("run layers " + std::string(option), "no effect on the scene 'layers'");
    expect_refused("plan bunnies --nodes 7", "no effect on the scene 'bunnies'");
    for (const char* option : {"--json", "--record", "--png", "--html", "--mesh-cache"})
        expect_refused("run tori --count 1 --seconds 0.1 " + std::string(option) + " ''",
                       "needs a name");
    expect_refused("sweep x.json --list --slurm", "--slurm");
    expect_refused("report paper --out /proc/nowhere", "/proc/nowhere");
    expect_refused("report accuracy --out /proc/nowhere", "/proc/nowhere");
    expect_refused("report accuracy --out " + path("report") + " --every 0", "--every");
    expect_refused("report", "subcommand");
    expect_refused("replay " + path("nothing"), "nothing");
    expect_refused("detect " + path("a.obj") + " " + path("b.obj"), "a.obj");
    expect_refused("detect " + path("a.obj"), "meshes");
    expect_refused("check", "meshes");
    expect_refused("check a.obj b.obj --fix c.obj", "--fix writes one mesh, but there are 2");
    expect_refused("check a.obj --inside perhaps", "perhaps");
    expect_refused("check a.obj --json /nowhere/x.json", "/nowhere/x.json");
    expect_refused("", "subcommand");
}

}  // namespace
}  // namespace pierce::test
