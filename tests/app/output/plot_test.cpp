// Plots: a CSV file always, and a picture where there is matplotlib.
#include "app/output/plot.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <sstream>

#include "app/output/draw_plots.hpp"
#include "support/command.hpp"
#include "support/csv.hpp"

namespace pierce::app {
namespace {

namespace fs = std::filesystem;
using test::AppTest;
using testing::HasSubstr;

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

bool shows(const std::string& picture, const std::string& text) {
    return picture.find(">" + text + "<") != std::string::npos;
}

/// Sets PIERCE_PYTHON as long as it is there.
class WithPython {
public:
    explicit WithPython(const std::string& python) {
        if (const char* value = std::getenv(name)) before_ = value;
        ::setenv(name, python.c_str(), 1);
    }
    ~WithPython() { ::setenv(name, before_.c_str(), 1); }
    WithPython(const WithPython&) = delete;
    WithPython& operator=(const WithPython&) = delete;

private:
    static constexpr const char* name = "PIERCE_PYTHON";
    std::string before_;
};

const Curves some_curves{.title = "Pairs missed",
                         .x = "time [s]",
                         .y = {"missed [%]"},
                         .table = {{"time", "full", "deepest"}, {{0, 0, 1}, {1, 2.5, 3}}},
                         .log_x = false,
                         .log_y = true,
                         .lines = {{.look = "full", .note = "open"}, {}}};
const HeatMap some_map{
    .title = "Missed",
    .x = "period",
    .y = "reach [edges]",
    .value = "missed [%]",
    .table = {{"K", "reach", "missed"}, {{1, 0, 0}, {2, 0, 12.5}, {1, 0.5, 50}, {2, 0.5, 99}}}};
const Scatter some_scatter{
    .title = "100 tori",
    .x = "time a frame [ms]",
    .y = {"pairs missed [%]", "depth missed [%]"},
    .corner = "fast",
    .points = {{.look = "overlaps", .x = 1, .y = {0, 0}, .stands_out = true},
               {.look = "gimpact", .x = 9, .y = {3, 0.01}}},
    .table = {.names = {"ms"}, .rows = {{1}, {9}}, .labels = {"overlaps", "gimpact"}}};

/// Where there is matplotlib.
class PlotTest : public AppTest {
protected:
    void SetUp() override {
        for (const std::string& python : drawing_pythons())
            if (python_.empty() && run(python, "-c 'import matplotlib' 2>/dev/null"))
                python_ = python;
        if (python_.empty()) GTEST_SKIP() << "matplotlib is not installed";
    }

    /// Draws, and returns the picture.
    template <class Plot>
    std::string drawn(const Plot& plot) {
        EXPECT_TRUE(write_plot(plot, folder, "plot", "made here"));
        EXPECT_EQ(test::read_csv(path("plot.csv")).made_with, "# made here");
        return text_of(folder / "plot.svg");
    }
    static bool run(const std::string& python, const std::string& arguments) {
        return std::system(("'" + python + "' " + arguments).c_str()) == 0;
    }

    std::string python_;
};

TEST_F(PlotTest, EveryKindHasItsNames) {
    const std::string curves = drawn(some_curves), map = drawn(some_map),
                      scatter = drawn(some_scatter);
    for (const char* text :
         {"Pairs missed", "time [s]", "missed [%]", "none", "full: all rays anew, open", "deepest"})
        EXPECT_TRUE(shows(curves, text)) << text;
    for (const char* text : {"Missed", "period", "reach [edges]", "missed [%]", "12.5", "99"})
        EXPECT_TRUE(shows(map, text)) << text;
    for (const char* text : {"100 tori", "pairs missed [%]", "depth missed [%]", "fast", "Pierce",
                             "overlaps (default)", "other libraries", "gimpact: Bullet, triangles"})
        EXPECT_TRUE(shows(scatter, text)) << text;
    for (const std::string& picture : {curves, map, scatter})
        EXPECT_NE(picture.find("@media (prefers-color-scheme: dark)"), std::string::npos);
}

TEST_F(PlotTest, TheSamePlotIsTheSameFile) {
    EXPECT_TRUE(drawn(some_curves) == drawn(some_curves));
    EXPECT_TRUE(drawn(some_map) == drawn(some_map));
    EXPECT_TRUE(drawn(some_scatter) == drawn(some_scatter));
}

TEST_F(PlotTest, AnyNameIsShownAsText) {
    const std::vector<std::string> names{"<script>alert(1)</script>", "$x_{1}^2$", "_under\\frac",
                                         "{brace} & 100 %",           "'a' \"b\"", "日本 €"};
    Curves curves = some_curves;
    curves.title = "a\x01" + names[0] + "\xff" + names[1];
    curves.x = names[1];
    curves.y = {names[2]};
    curves.table = {{"time"}, {std::vector<double>(names.size() + 1, 1)}};
    curves.lines.clear();
    for (const std::string& name : names) {
        curves.table.names.push_back(name);
        curves.lines.push_back({.name = name});
    }
    const std::string picture = drawn(curves);
    for (const char* part : {"<script", "\x01", "\xff"})
        EXPECT_EQ(picture.find(part), std::string::npos) << part;
    for (const std::string& name : names) {
        std::string shown;
        for (const char letter : name)
            shown += letter == '&'   ? "&amp;"
                     : letter == '<' ? "&lt;"
                     : letter == '>' ? "&gt;"
                                     : std::string(1, letter);
        EXPECT_TRUE(shows(picture, shown)) << name;
    }
}

TEST_F(PlotTest, TakesNothingFromTheCurrentFolder) {
    std::ofstream(folder / "json.py") << "raise SystemExit(1)\n";
    const fs::path before = fs::current_path();
    fs::current_path(folder);
    EXPECT_TRUE(write_plot(some_curves, folder, "plot", ""));
    fs::current_path(before);
}

TEST_F(PlotTest, ALookThatThereIsNotIsAnError) {
    Curves curves = some_curves;
    curves.lines[0].look = "sat";
    EXPECT_FALSE(write_plot(curves, folder, "plot", ""));
    EXPECT_EQ(draw_plots(std::vector{description_of(curves, folder / "plot.svg")}),
              "Python could not draw it");
    EXPECT_FALSE(fs::exists(folder / "plot.svg"));
}

TEST_F(PlotTest, EveryComparedMethodHasALook) {
    ASSERT_EQ(test::pierce("run tori --count 1 --seconds 0.02 --record " + path("motion")).code, 0);
    const std::string text = test::pierce("compare " + path("motion") + " --methods sat").text,
                      before = "there are: ";
    ASSERT_THAT(text, HasSubstr(before));
    std::istringstream methods(text.substr(text.find(before) + before.size()));
    Scatter scatter = some_scatter;
    scatter.points.clear();
    for (std::string name; std::getline(methods >> std::ws, name, ',');) {
        name.erase(name.find_last_not_of(" \n") + 1);
        scatter.points.push_back({.look = name, .x = 1, .y = {1, 1}});
    }
    EXPECT_GT(scatter.points.size(), 10u);
    const std::string picture = drawn(scatter);
    for (const Scatter::Point& point : scatter.points)
        EXPECT_NE(picture.find(">" + point.look), std::string::npos) << point.look;
}

TEST_F(PlotTest, PicturesAreLegible) {
    const std::string source = PIERCE_SOURCE_FOLDER;
    ::setenv("PYTHONPATH", (source + "/src/app/output").c_str(), 1);
    EXPECT_TRUE(run(python_, "-B '" + source + "/tests/app/output/draw_plots_test.py'"));
}

using NoPlotTest = AppTest;

TEST_F(NoPlotTest, WithoutMatplotlibThereIsStillATable) {
    const WithPython none("/nowhere/python3");
    EXPECT_FALSE(write_plot(some_curves, folder, "curves", "made here"));
    EXPECT_FALSE(write_plot(some_map, folder, "map", "made here"));
    EXPECT_FALSE(write_plot(some_scatter, folder, "scatter", "made here"));
    for (const char* name : {"curves", "map", "scatter"}) {
        EXPECT_EQ(test::read_csv(path(name) + ".csv").made_with, "# made here");
        EXPECT_FALSE(fs::exists(path(name) + ".svg"));
    }
    EXPECT_EQ(draw_plots(std::vector{description_of(some_map, folder / "map.svg")}),
              "matplotlib is not installed");
    EXPECT_EQ(draw_plots({}), "") << "nothing is asked for";
}

TEST_F(NoPlotTest, AReportSaysThatThereAreNoPictures) {
    const WithPython none("/nowhere/python3");
    const test::Outcome report = test::pierce(
        "report cloth --parts accuracy --nodes 8 --seconds 1 --out " + path("report"));
    ASSERT_EQ(report.code, 0) << report.text;
    for (const char* file : {"report.md", "report.html"})
        EXPECT_THAT(text_of(folder / "report" / file),
                    HasSubstr("(no picture: matplotlib is not installed)"));
}

using TableTest = AppTest;

TEST_F(TableTest, IsReadAsItWasWritten) {
    const Table table{.names = {"a, b", "c"}, .rows = {{1.5, 0}, {-2, 3e-7}}, .labels = {"x", "y"}};
    table.write_csv(path("table.csv"), "{\"seed\":1}");
    const Table read = Table::read_csv(path("table.csv"));
    EXPECT_EQ(read.made_with, "{\"seed\":1}");
    EXPECT_EQ(read.names, (std::vector<std::string>{"a; b", "c"}));
    EXPECT_EQ(read.labels, table.labels);
    EXPECT_EQ(read.rows, table.rows);
}

}  // namespace
}  // namespace pierce::app
