// What `pierce report paper` writes.
#include <gmock/gmock.h>

#include <algorithm>

#include "support/command.hpp"
#include "support/csv.hpp"

namespace pierce::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

const std::string small =
    "report paper --count 4 --bunnies 3 --seconds 1.5 --soft-seconds 1 --cloth-seconds 0.2 "
    "--landing-seconds 1.5 --runs 2 --truth-every 2 ";

/// Checks points and their line of least squares.
void expect_line(const Csv& steps, const std::string& name) {
    const std::vector<double> dt = steps.column("dt"), measured = steps.column(name),
                              line = steps.column(name + " (line)");
    double off = 0, turned = 0;
    for (std::size_t i = 0; i < 7; ++i) {
        const double residual = (measured[i] - line[i]) / measured[6];
        off += residual;
        turned += residual * dt[i] / dt[6];
    }
    EXPECT_NEAR(off, 0, 1e-4) << "a line of least squares leaves nothing on average";
    EXPECT_NEAR(turned, 0, 1e-4) << "nor along it";
}

TEST_F(AppTest, ReportsOnThePaper) {
    const Outcome report = pierce(small + "--out " + path("report"));
    ASSERT_EQ(report.code, 0) << report.text;
    const fs::path out = folder / "report";
    const std::string page = text_of(out / "report.md");
    for (int table = 1; table <= 4; ++table)
        EXPECT_TRUE(page.find("Table " + std::to_string(table)) != std::string::npos ||
                    page.find("Tables 2 and 3") != std::string::npos)
            << table;
    for (int figure = 7; figure <= 16; ++figure)
        EXPECT_THAT(page, HasSubstr("## Figure " + std::to_string(figure)));
    for (const char* part : {"| bunnies_soft | certified | 0 of", "R²", "needs a GPU", "| commit |",
                             "| seed | 1 |", "Why Algorithm 1"})
        EXPECT_THAT(page, HasSubstr(part));
    EXPECT_THAT(page, testing::Not(HasSubstr("could not draw")));
    for (const char* file :
         {"figure_7_at_rest.png", "figure_8_falling.png", "figure_15_folded.png"})
        EXPECT_GT(fs::file_size(out / file), 1000u) << file;

    // All of it in one file, and nothing is asked of another.
    const std::string html = text_of(out / "report.html");
    EXPECT_THAT(html, HasSubstr("<table>"));
    EXPECT_THAT(html, HasSubstr("data:image/png;base64,"));
    for (std::size_t at = html.find("src=\""); at != std::string::npos;
         at = html.find("src=\"", at + 1))
        EXPECT_EQ(html.compare(at, 10, "src=\"data:"), 0) << html.substr(at, 60);

    std::size_t tables = 0;
    for (const auto& entry : fs::directory_iterator(out)) {
        if (entry.path().extension() != ".csv") continue;
        ++tables;
        const std::string made_with = read_csv(entry.path()).made_with;
        for (const char* part : {"\"commit\":", "\"processor\":", "\"seed\":1", "\"embree\":"})
            EXPECT_THAT(made_with, HasSubstr(part)) << entry.path();
    }
    EXPECT_GT(tables, 25u);

    for (const double differ : read_csv(out / "table_1_host.csv").column("differ"))
        EXPECT_EQ(differ, 0) << "contacts do not depend on trees";
    for (const std::string scene : {"10_bunnies", "11_bunnies", "12_tori", "13_tori"}) {
        const Csv open = read_csv(out / ("figure_" + scene + "_open.csv")),
                  closed = read_csv(out / ("figure_" + scene + "_closed.csv")),
                  soft = read_csv(out / ("figure_" + scene + "_soft_open.csv"));
        for (const char* name : {"time", "rays", "GJK/EPA", "truth"})
            EXPECT_TRUE(open.has_column(name)) << scene << name;
        for (const char* name :
             {"time", "rays", "truth", "GJK/EPA; margins count", "GJK/EPA; what overlaps",
              "truth of GJK/EPA", "GJK/EPA; margins of 0.001; what overlaps"})
            EXPECT_TRUE(closed.has_column(name)) << scene << name;
        for (const char* name : {"time", "rays", "GImpact", "truth"})
            EXPECT_TRUE(soft.has_column(name)) << scene << name;
    }
    for (const std::string scene : {"10_bunnies_open", "12_tori_open", "12_tori_soft_open"}) {
        const Csv open = read_csv(out / ("figure_" + scene + ".csv"));
        const std::vector<double> truth = open.column("truth"),
                                  rays = open.column("rays by some depth");
        EXPECT_GT(std::ranges::max(rays), 1);
        for (std::size_t i = 0; i < truth.size(); ++i)
            EXPECT_GE(truth[i], rays[i])
                << "rays from vertices invent no pair; figure " << scene << " row " << i;
    }
    const Csv steps = read_csv(out / "figure_14_tori.csv");
    const std::vector<double> dt = steps.column("dt"), mean = steps.column("mean"),
                              most = steps.column("maximum"),
                              deviation = steps.column("standard deviation");
    ASSERT_EQ(dt.size(), 7u);
    EXPECT_NEAR(dt.back(), 8.0 / 120, 1e-6);
    for (std::size_t i = 0; i < 7; ++i) {
        EXPECT_GT(mean[i], 0);
        EXPECT_GT(most[i], mean[i]);
        EXPECT_LT(deviation[i], most[i]);
    }
    for (const std::string name : {"mean", "maximum", "standard deviation"})
        expect_line(steps, name);
}

TEST_F(AppTest, MergesWhatAGpuHasMeasured) {
    fs::create_directories(folder / "results");
    std::ofstream(folder / "results" / "table_1_gpu.csv")
        << "# {\"machine\":\"elsewhere\"}\n"
           "row,update_ms,narrow_ms,total_ms,boxes_and_pairs_ms,differ\n"
           "trbvh; rebuilt,1.25,0.5,1.75,0.125,0\n";
    const Outcome report = pierce(small + "--parts trees,gpu,crossover --gpu-results " +
                                  path("results") + " --out " + path("merged"));
    ASSERT_EQ(report.code, 0) << report.text;
    const std::string page = text_of(folder / "merged" / "report.md");
    EXPECT_THAT(page, HasSubstr("| trbvh, rebuilt | 1.250 | 0.500 | 1.750 | 0.125 | 0 |"));
    EXPECT_THAT(page, HasSubstr("elsewhere"));
    EXPECT_THAT(page, HasSubstr("`crossover.csv` is not in the folder of results"));
    EXPECT_TRUE(fs::exists(folder / "merged" / "table_1_gpu.csv"));

    std::ofstream(folder / "results" / "table_1_gpu.csv") << "row,update_ms\nlbvh,fast\n";
    expect_refused(
        small + "--parts trees --gpu-results " + path("results") + " --out " + path("merged"),
        "no number in 'fast'");
}

}  // namespace
}  // namespace pierce::test
