// pierce compare: methods on the same recorded frames, against the truth.
#include <gmock/gmock.h>

#include <algorithm>

#include "support/command.hpp"

namespace pierce::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class CompareCommandTest : public AppTest {
protected:
    void record(const std::string& how) {
        const Outcome outcome = pierce("run tori --count 4 " + how + " --record " + path("motion"));
        ASSERT_EQ(outcome.code, 0) << outcome.text;
    }

    Outcome compare(const std::string& how) {
        return pierce("compare " + path("motion") + " " + how);
    }
};

/// What a comparison wrote about a method.
json of_method(const json& written, const std::string& name) {
    for (const json& method : written["methods"])
        if (method["method"] == name) return method;
    return {};
}

TEST_F(CompareCommandTest, ShowsTimeBesideError) {
    ASSERT_NO_FATAL_FAILURE(record("--seconds 2"));
    const Outcome outcome = compare("--methods full,complete,gimpact --json " +
                                    path("compare.json") + " --plots " + path("plots"));
    ASSERT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_THAT(
        outcome.text,
        AllOf(HasSubstr("5 bodies, 120 frames, 30 of them with the truth, 1 thread\n"),
              HasSubstr("ms/frame"), HasSubstr("missed pairs"), HasSubstr("normal off [deg]")));
    for (const char* name : {"\n  full ", "\n  complete ", "\n  gimpact "})
        EXPECT_THAT(outcome.text, HasSubstr(name));
    EXPECT_THAT(outcome.text, AllOf(Not(HasSubstr("certified")), Not(HasSubstr("left out"))));

    const json written = read("compare.json");
    for (const char* key : {"machine", "versions", "settings", "methods"})
        EXPECT_TRUE(written.contains(key)) << key;
    EXPECT_EQ(written["settings"]["folder"], "motion");
    EXPECT_EQ(written["settings"]["threads"], 1);
    ASSERT_EQ(written["methods"].size(), 3u);
    std::size_t pairs = 0, vertices = 0;
    const json truth = read("motion/truth.json");
    for (const json& frame : truth["frames"]) {
        pairs += frame["overlapping"].size();
        vertices += frame["inside"].size();
    }
    ASSERT_GT(pairs, 0u);
    ASSERT_GT(vertices, 0u);
    for (const json& method : written["methods"]) {
        EXPECT_EQ(method["pairs"], pairs);
        EXPECT_EQ(method["vertices"], vertices);
        EXPECT_GT(method["ms"]["median"].get<double>(), 0);
        EXPECT_GT(method["contacts_per_frame"].get<double>(), 0);
        for (const char* key : {"missed_pairs", "false_pairs", "missed_vertices", "false_vertices",
                                "missed_depth_share", "missed_pair_depth_share", "depth_ratio",
                                "normal_error_degrees", "pair_depth_ratio"})
            EXPECT_TRUE(method.contains(key)) << key;
    }
    const json complete = of_method(written, "complete");
    EXPECT_EQ(complete["missed_pairs"], 0);
    EXPECT_EQ(complete["false_pairs"], 0);
    EXPECT_EQ(complete["false_vertices"], 0);
    const json full = of_method(written, "full");
    EXPECT_EQ(full["false_pairs"], 0);
    EXPECT_GT(full["depth_ratio"]["median"].get<double>(), 0.99)
        << "along the normal it is no shorter than the way out";
    EXPECT_GT(fs::file_size(folder / "plots" / "f1_speed_against_error.csv"), 20u);
}

TEST_F(CompareCommandTest, ComparesAllMethodsThatCanServe) {
    ASSERT_NO_FATAL_FAILURE(record("--seconds 0.2 --soft"));
    const Outcome outcome = compare("--every 6 --threads 2");
    ASSERT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_THAT(outcome.text, HasSubstr("2 of them with the truth, 2 threads\n"));
    for (const char* name : {"full", "walk", "walk-predict", "certified", "overlaps", "complete",
                             "reprojected", "gimpact"})
        EXPECT_THAT(outcome.text, HasSubstr("\n  " + std::string(name) + " ")) << name;
    for (const char* name : {"gjk-hull", "gjk-epa"})
        EXPECT_THAT(outcome.text, HasSubstr("  left out: " + std::string(name) +
                                            ": its shapes cannot follow deforming bodies"));
    const auto frames_of = [&](const std::string& how) {
        const std::string file = path("sampling.json");
        const Outcome again = compare(how + " --methods full --json " + file);
        EXPECT_EQ(again.code, 0) << again.text;
        const std::size_t at = again.text.find(" frames, ") + 9;
        return std::pair(std::atoi(again.text.c_str() + at),
                         read("sampling.json")["settings"]["every"].get<int>());
    };
    EXPECT_EQ(frames_of(""), std::pair(2, 6)) << "the truth there is, is used";
    EXPECT_EQ(frames_of("--every 12"), std::pair(1, 12)) << "a part of it";
    EXPECT_EQ(frames_of(""), std::pair(2, 6));
    EXPECT_EQ(frames_of("--every 2"), std::pair(6, 2)) << "made anew";
    EXPECT_EQ(frames_of("--every 4"), std::pair(3, 4));
    expect_refused("compare " + path("motion") + " --methods gjk-epa",
                   "its shapes cannot follow deforming bodies");
}

TEST_F(CompareCommandTest, RefusesWhatItCannotCompare) {
    expect_refused("compare", "folder");
    expect_refused("compare " + path("motion"), "motion/scene.json");
    ASSERT_NO_FATAL_FAILURE(record("--seconds 0.05"));
    const std::string motion = "compare " + path("motion");
    expect_refused(motion + " --methods full,sat",
                   "unknown method 'sat'; there are: full, walk, walk-predict, certified, "
                   "overlaps, complete, reprojected, gjk-hull, "
                   "gjk-epa, gimpact, fcl");
    expect_refused(motion + " --threads 0", "--threads");
    expect_refused(motion + " --every 0", "--every");
    expect_refused(motion + " --json /nowhere/x.json", "/nowhere/x.json");
    EXPECT_FALSE(fs::exists(folder / "motion" / "truth.json")) << "refused before any work is done";
    std::ofstream(folder / "motion" / "truth.json") << "{}";
    expect_refused(motion, "truth.json' is not a truth file");
}

}  // namespace
}  // namespace pierce::test
