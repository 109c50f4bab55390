#include "app/paper_sections.hpp"
#include "app/statistics.hpp"

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
    const std::string name = fmt::format("figure_{}", figure);
    const auto section = [&](const char* loop, const std::vector<Judged>& judged) {
        page.line("");
        depth_table(judged, page);
        page.plot(Curves{.title = fmt::format("Average penetration depth, {} {}, loop {}",
                                              quality.count, quality.scene, loop),
                         .x = "time [s]",
                         .y = "mean depth",
                         .table = over_time(quality.time, columns_of(judged, &Sight::depth),
                                            depth_window)},
                  name + "_" + loop);
    };
    page.line("## Figure {}: average penetration depth, {} {}\n", figure, quality.count,
              quality.scene);
    page.line(
        "The paper: rays' depth is \"just a little larger\" than GJK/EPA's. Mean over a method's "
        "contacts in a frame, those "
        "that only touch with depth zero; for the truth over the vertices strictly inside a body, "
        "their depth being the "
        "distance to its surface; then over frames. GJK/EPA's contacts are of crossing edges, too, "
        "which lie deeper.\n");
    page.line(
        "Loop open: all on the motion that rays brought about, GJK/EPA without Bullet's margin.");
    section("open", quality.open);
    page.line(
        "Loop closed, as in the paper: each method on the motion it brought about. GJK/EPA's "
        "depths count from Bullet's "
        "margins; the truth's from the meshes.");
    section("closed", quality.closed);
}

}  // namespace pierce::app
