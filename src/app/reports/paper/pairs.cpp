#include "app/output/statistics.hpp"
#include "app/reports/paper/sections.hpp"

namespace pierce::app {
namespace {

void judgement(const std::vector<Judged>& judged, Page& page) {
    page.line(
        "\n| | concordance with the truth | overlapping pairs missed | found by some depth, but "
        "not overlapping | pairs a frame | truth | in the last quarter | truth "
        "|\n|---|---|---|---|---|---|---|---|");
    for (const auto& [found, truth] : judged)
        page.line("| {} | {:.3f} | {:.2f} % | {:.2f} % | {:.1f} | {:.1f} | {:.1f} | {:.1f} |",
                  found.name, concordance(found.pairs, truth.pairs),
                  100 * found.missed_share(truth), 100 * found.added_share(), mean(found.pairs),
                  mean(truth.pairs), mean(last_quarter(found.pairs)),
                  mean(last_quarter(truth.pairs)));
    page.line("");
    for (std::size_t i = 1; i < judged.size(); ++i)
        page.line("Concordance of rays with {}: {:.3f}.", judged[i].found.name,
                  concordance(judged[0].found.pairs, judged[i].found.pairs));
}

}  // namespace

void colliding_pairs(const Quality& quality, int figure, Page& page) {
    const auto curves = [&](const char* loop, const std::vector<Judged>& judged) {
        std::vector<TimeColumn> columns = columns_of(judged, &Sight::pairs);
        columns.push_back({.name = "rays by some depth",
                           .values = judged[0].found.deep_pairs,
                           .line = {.look = "full", .stroke = Stroke::dotted}});
        page.plot(Curves{.title = fmt::format("Colliding pairs, {}, loop {}", quality.scene, loop),
                         .x = "time [s]",
                         .y = {"colliding pairs"},
                         .table = over_time(quality.time, columns),
                         .lines = lines_of(columns)},
                  fmt::format("figure_{}_{}_{}", figure, quality.file, loop));
    };
    page.line("\n## Figure {}: colliding pairs in each frame, {}\n", figure, quality.scene);
    page.line(
        "The paper: \"two curves has a high concordance\", those of rays and GJK. Bodies that only "
        "touch collide, too, but need not overlap in truth. Concordance is Lin's, 1 at best.\n");
    page.line("Loop open: all on the motion that rays brought about; {} without Bullet's margin.",
              quality.soft ? "GImpact, triangle against triangle, as GJK has no convex pieces here,"
                           : "GJK/EPA on convex pieces,");
    judgement(quality.open, page);
    curves("open", quality.open);
    if (quality.soft) {
        page.line(
            "Bullet's own methods cannot close the loop for soft bodies: it has none that keeps "
            "their triangles apart.");
        return;
    }
    page.line(
        "Loop closed, as in the paper: each method on the motion it brought about. Bullet keeps "
        "bodies its margins apart, 0.04 around each. *Margins count*: pairs whose margins overlap. "
        "*What overlaps*: pairs of the same motion whose shapes overlap. The last run has margins "
        "a fortieth as thick. The truth is that of the meshes.");
    judgement(quality.closed, page);
    curves("closed", quality.closed);
}

}  // namespace pierce::app
