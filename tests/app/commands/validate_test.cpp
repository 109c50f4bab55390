// pierce validate, and what the command says about the backend it runs on.
#include <gmock/gmock.h>

#include <cstdint>
#include <map>
#include <string>

#include "support/backends.hpp"
#include "support/command.hpp"

namespace pierce::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class ValidateCommandTest : public AppTest {};

TEST_F(ValidateCommandTest, FindsThatAllBackendsOfASceneAgree) {
    for (const std::string how : {" --coverage vertices", " --soft --coverage complete"}) {
        const Outcome outcome = pierce("validate tori --count 4 --seconds 1.5 --every 10" + how +
                                       " --json " + path("validation.json"));
        ASSERT_EQ(outcome.code, 0) << outcome.text;
        EXPECT_THAT(outcome.text,
                    AllOf(HasSubstr("tori: 5 bodies, 9 of 90 frames\n"), HasSubstr("wrong frames"),
                          HasSubstr("all backends have the same contacts in every frame\n")));
        const json written = read("validation.json");
        ASSERT_EQ(written["modes"].size(), 4u);
        std::map<std::string, std::uint32_t> contacts;
        for (const json& mode : written["modes"]) {
            EXPECT_EQ(mode["frames"], 9);
            EXPECT_EQ(mode["differing_frames"], 0);
            EXPECT_TRUE(mode["wrong"].empty());
            ASSERT_EQ(mode["backends"].size(), has_backend("cuda") ? 4u : 3u);
            for (const json& backend : mode["backends"]) {
                EXPECT_GT(backend["contacts"], mode["mode"] == "walk" ? 0 : 10);
                EXPECT_EQ(backend["contacts"], mode["backends"][0]["contacts"]);
                EXPECT_GT(backend["ms"]["median"], 0);
            }
            contacts[mode["mode"]] = mode["backends"][0]["contacts"];
        }
        EXPECT_EQ(contacts["certified"], contacts["full"]);
        EXPECT_LT(contacts["walk"], contacts["full"]);
        EXPECT_LE(contacts["walk"], contacts["walk-predict"]);
        EXPECT_EQ(outcome.text.find("left out: cuda: the cuda backend cannot run here: ") ==
                      std::string::npos,
                  has_backend("cuda"))
            << outcome.text;
    }
}

TEST_F(ValidateCommandTest, TakesRecordingsAndTheBackendsItIsTold) {
    ASSERT_EQ(pierce("run tori --count 3 --seconds 1.5 --record " + path("motion")).code, 0);
    const Outcome outcome = pierce("validate " + path("motion") +
                                   " --every 20 --modes walk,certified --backends bvh,embree");
    EXPECT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_THAT(outcome.text, AllOf(HasSubstr("4 bodies, 5 of 90 frames"), HasSubstr("embree 3."),
                                    HasSubstr("bvh, 1 thread"), HasSubstr("\n walk\n"),
                                    HasSubstr("\n certified\n"), Not(HasSubstr("\n full\n")),
                                    Not(HasSubstr("reference")), Not(HasSubstr("left out"))));
}

TEST_F(ValidateCommandTest, LeavesTheReferenceOutOfLargeScenes) {
    const Outcome outcome = pierce("validate tori --count 600 --seconds 0.02");
    EXPECT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_THAT(outcome.text, HasSubstr("left out: reference: brute force takes long"));
}

TEST_F(ValidateCommandTest, RefusesWhatItCannotValidate) {
    expect_refused("validate", "input");
    expect_refused("validate tear --count 9", "--count: has no effect on the scene 'tear'");
    expect_refused("validate torus",
                   "'torus' is neither a scene, see 'pierce scenes', nor a recording's folder");
    expect_refused("validate " + path("nothing"), "nothing");
    expect_refused("validate " + folder.string(), "scene.json");
    expect_refused("validate " + folder.string() + " --count 3",
                   "--count, --soft and --seconds are for scenes");
    expect_refused("validate tori --every 0", "--every");
    expect_refused("validate tori --seconds 0", "--seconds");
    expect_refused("validate tori --modes paper", "--modes");
    expect_refused("validate tori --backends bvh", "--backends");
    expect_refused("validate tori --backends bvh,optix", "unknown backend 'optix'");
    expect_refused("validate tori --json /nowhere/x.json", "/nowhere/x.json");
}

TEST_F(ValidateCommandTest, SaysWhyThereIsNoCuda) {
    if (has_backend("cuda")) GTEST_SKIP() << "there is";
    for (const std::string command : {"run tori --count 1", "validate tori --backends cuda,bvh"}) {
        const std::string how = command.starts_with("run") ? " --backend cuda" : "";
        expect_refused(command + how, "pierce: the cuda backend cannot run here: ");
#if !PIERCE_HAS_CUDA
        expect_refused(command + how, "this build has no CUDA (PIERCE_CUDA=ON)");
#endif
    }
}

TEST_F(ValidateCommandTest, SaysWhatAutomaticCameTo) {
    const Outcome outcome = pierce("run tori --count 1 --seconds 0.1 --backend automatic");
    EXPECT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_THAT(outcome.text,
                HasSubstr(has_backend("cuda") ? "method rays, cuda, " : "method rays, embree "));
}

}  // namespace
}  // namespace pierce::test
