#include "app/output/statistics.hpp"
#include "app/reports/paper/sections.hpp"

namespace pierce::app {
namespace {

void depth_table(const std::vector<Judged>& judged, Page& page) {
    page.line("| | mean depth | truth | in the last quarter | truth |");
    page.line("|---|---|---|---|---|");
    for (const auto& [found, truth] : judged)
        page.line("| {} | {:.5f} | {:.5f} | {:.5f} | {:.5f} |", found.name, mean(found.depth),
                  mean(truth.depth), mean(last_quarter(found.depth)),
                  mean(last_quarter(truth.depth)));
}

}  // namespace

void average_depth(const Quality& quality, int figure, Page& page) {
    const auto section = [&](const char* loop, const std::vector<Judged>& judged) {
        page.line("");
        depth_table(judged, page);
        const std::vector<TimeColumn> columns = columns_of(judged, &Sight::depth);
        page.plot(Curves{.title = fmt::format("Average penetration depth, {}, loop {}",
                                              quality.scene, loop),
                         .x = "time [s]",
                         .y = {"mean depth [length]"},
                         .table = over_time(quality.time, columns, depth_window),
                         .lines = lines_of(columns)},
                  fmt::format("figure_{}_{}_{}", figure, quality.file, loop));
    };
    page.line("\n## Figure {}: average penetration depth, {}\n", figure, quality.scene);
    page.line(
        "The paper: rays' depth is \"just a little larger\" than GJK/EPA's. Mean over a method's "
        "contacts in a frame, those that only touch with depth zero; for the truth over the "
        "vertices strictly inside a body, their depth being the distance to its surface; then over "
        "frames. {}'s contacts are of crossing edges, too, which lie deeper.\n",
        quality.opponent);
    page.line("Loop open: all on the motion that rays brought about, {} without Bullet's margin.",
              quality.opponent);
    section("open", quality.open);
    if (quality.soft) return;
    page.line(
        "Loop closed, as in the paper: each method on the motion it brought about. Where margins "
        "count, depths count from Bullet's margins; the truth's from the meshes.");
    section("closed", quality.closed);
}

}  // namespace pierce::app
