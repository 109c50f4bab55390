// What `pierce report accuracy` writes.
#include <gmock/gmock.h>

#include <cmath>
#include <set>

#include "support/command.hpp"
#include "support/csv.hpp"

namespace pierce::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

int count(const std::string& text, const std::string& part) {
    int found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++found;
    return found;
}

TEST_F(AppTest, ReportsOnAccuracy) {
    const Outcome report = pierce(
        "report accuracy --count 5 --seconds 2 --every 6 --poses 12 --rays 1000 --out " +
        path("report"));
    ASSERT_EQ(report.code, 0) << report.text;
    const fs::path out = folder / "report";
    std::ifstream in(out / "report.md");
    const std::string page{std::istreambuf_iterator<char>(in), {}};
    for (const char* part :
         {"### tori_soft", "Left out: gjk-epa", "Leaks over", "ratio of resolutions",
          "Depth over overlap", "| 25 | comoving_fold, after it | no contact |"})
        EXPECT_THAT(page, HasSubstr(part));
    EXPECT_THAT(page, testing::Not(HasSubstr("could not draw")));
    for (const char* name : {"f1_tori", "f1_bunnies", "f1_tori_soft", "f1_tear"}) {
        const Csv csv = read_csv(out / (std::string(name) + ".csv"));
        EXPECT_GT(csv.number("full", "ms"), 0) << name;
        EXPECT_GT(csv.number("complete", "pairs"), 0) << name;
        for (const char* method : {"complete", "reprojected"})
            for (const char* column : {"missed_pairs", "false_pairs"})
                EXPECT_EQ(csv.number(method, column), 0) << name << ' ' << method << ' ' << column;
        for (const char* column :
             {"depth_ratio_median", "depth_ratio_p95", "normal_error_degrees_median"})
            EXPECT_TRUE(std::isfinite(csv.number("reprojected", column))) << name << ' ' << column;
        if (std::ifstream svg(out / (std::string(name) + ".svg")); svg) {
            const std::string picture{std::istreambuf_iterator<char>(svg), {}};
            for (const auto& row : csv.rows)
                EXPECT_EQ(count(picture, ">" + row.at("name") + ":") +
                              count(picture, ">" + row.at("name") + " (default)<"),
                          1)
                    << name << ' ' << row.at("name") << ": once, in the legend";
        }
    }
    const Csv resolution = read_csv(out / "f7_resolution.csv"),
              depth = read_csv(out / "f9_depth.csv"), hard = read_csv(out / "hard_cases.csv");
    ASSERT_EQ(resolution.rows.size(), 21u);
    for (const auto& row : resolution.rows)
        for (const char* method : {"overlaps", "complete"})
            EXPECT_EQ(row.at(method), "0") << method << ", ratio " << row.at("ratio");
    ASSERT_EQ(depth.rows.size(), 6u);
    for (const auto& row : depth.rows) {
        EXPECT_GT(std::stod(row.at("inward rays median")), 1.02);
        EXPECT_NEAR(std::stod(row.at("re-projected p95")), 1, 0.1);
    }
    const Csv damaged = read_csv(out / "damaged_meshes.csv");
    ASSERT_EQ(damaged.rows.size(), 24u);
    for (const auto& row : damaged.rows) {
        EXPECT_LE(std::stod(row.at("inside changed [%]")), 3) << row.at("mesh");
        EXPECT_LE(std::stoi(row.at("missed pairs")), std::stoi(row.at("missed pairs; not closed")));
        if (row.at("mesh").ends_with("turned")) {
            EXPECT_EQ(std::stod(row.at("inside changed [%]")), 0) << row.at("mesh");
        }
    }
    std::set<std::string> cases;
    for (const auto& row : hard.rows) cases.insert(row.at("case"));
    EXPECT_EQ(cases.size(), 25u);
    for (const char* at : {"vertices", "edges"})
        for (const auto& row : read_csv(out / ("f6_leaks_" + std::string(at) + ".csv")).rows)
            EXPECT_EQ(row.at("pierce"), "0") << "offset " << row.at("offset");
}

}  // namespace
}  // namespace pierce::test
