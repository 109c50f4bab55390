// `pierce report cloth`: its page, and what it says of sheets that are kept apart.
#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "support/command.hpp"

namespace pierce::test {
namespace {

using testing::HasSubstr;

using ClothReportTest = AppTest;

TEST_F(ClothReportTest, ShowsTimeBesideErrorForEverySize) {
    const Outcome report = pierce(
        "report cloth --parts size --sizes 8,12 --size-seconds 0.9 --layers-nodes 4 --threads 2 "
        "--out " +
        path("report"));
    ASSERT_EQ(report.code, 0) << report.text;
    std::ifstream in(folder / "report" / "report.md");
    const std::string page = (std::stringstream() << in.rdbuf()).str();
    for (const char* part : {"## Time and error as sheets get finer", "cloth-capsule 12",
                             "layers 4", "bullet-clusters"})
        EXPECT_THAT(page, HasSubstr(part));
    EXPECT_THAT(page, testing::Not(HasSubstr("## Missed and invented crossings")))
        << "one part was asked for";

    const nlohmann::json all = read("report/size.json");
    std::uint64_t meetings = 0;
    // Two sizes, tried and kept, and the layers: one and two threads, and clusters.
    ASSERT_EQ(all["rows"].size(), 15u);
    for (const nlohmann::json& row : all["rows"]) {
        SCOPED_TRACE(row.dump());
        EXPECT_GT(row["timed_steps"], 0);
        EXPECT_GT(row["truth_steps"], 0);
        EXPECT_GE(row["ms_p95"], row["ms_median"]);
        if (row["method"] != "continuous") continue;
        EXPECT_EQ(row["recall"], 1);
        EXPECT_EQ(row["precision"], 1);
        meetings += row["meet"].get<std::uint64_t>();
        if (row["ends"] != "kept") continue;
        EXPECT_EQ(row["meet"], 0) << "what is kept apart does not meet";
        EXPECT_EQ(row["exact_self_penetration"], 0);
        if (row["scene"] != "cloth-capsule") continue;
        EXPECT_EQ(row["self_penetration_max"], 0);
    }
    EXPECT_GT(meetings, 0u) << "Bullet has put the sheet through something";
}

TEST_F(ClothReportTest, DrawsWhatItMeasures) {
    const Outcome report = pierce("report cloth --parts accuracy --nodes 8 --seconds 1 --html " +
                                  path("one.html") + " --out " + path("report"));
    ASSERT_EQ(report.code, 0) << report.text;
    std::ifstream in(folder / "report" / "report.md");
    const std::string page = (std::stringstream() << in.rdbuf()).str();
    EXPECT_THAT(page, HasSubstr("(f8_ray_length_cloth-twist.")) << "a picture, or a table";
    EXPECT_THAT(page, testing::Not(HasSubstr("could not draw")));
    EXPECT_TRUE(std::filesystem::exists(path("one.html")));
    EXPECT_FALSE(std::filesystem::exists(folder / "report" / "report.html"));
}

TEST_F(ClothReportTest, RefusesPartsThereAreNot) {
    expect_refused("report cloth --parts times --out " + path("report"), "--parts");
}

TEST_F(ClothReportTest, FinerSheetsAreSimulatedInSmallerSteps) {
    ASSERT_EQ(pierce("run cloth-capsule --nodes 39 --seconds 0.05 --json " + path("run.json")).code,
              0);
    EXPECT_NEAR(read("run.json")["settings"]["dt"].get<double>(), 1.0 / 120, 1e-9)
        << "half the distance, half the step";
    ASSERT_EQ(pierce("run cloth-capsule --nodes 39 --seconds 0.05 --dt 0.025 --json " +
                     path("given.json"))
                  .code,
              0);
    EXPECT_EQ(read("given.json")["frames"].size(), 2u);
}

}  // namespace
}  // namespace pierce::test
