#include "app/paper_sections.hpp"
#include "app/statistics.hpp"

namespace pierce::app {
namespace {

void counts(const std::vector<Judged>& judged, Page& page) {
    page.line("\n| | pairs a frame | truth | in the last quarter | truth |\n|---|---|---|---|---|");
    for (const auto& [found, truth] : judged)
        page.line("| {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |", found.name, mean(found.pairs),
                  mean(truth.pairs), mean(last_quarter(found.pairs)),
                  mean(last_quarter(truth.pairs)));
    page.line("\nConcordance of rays with GJK/EPA: {:.3f}.",
              concordance(judged[0].found.pairs, judged[1].found.pairs));
}

void errors(const std::vector<Judged>& judged, Page& page) {
    page.line(
        "\n| | overlapping pairs missed | found by some depth, but not overlapping | concordance "
        "with the truth "
        "|\n|---|---|---|---|");
    for (const auto& [found, truth] : judged)
        page.line("| {} | {:.2f} % | {:.2f} % | {:.3f} |", found.name,
                  100 * found.missed_share(truth), 100 * found.added_share(),
                  concordance(found.pairs, truth.pairs));
}

}  // namespace

void colliding_pairs(const Quality& quality, int figure, Page& page) {
    const auto curves = [&](const char* loop, const std::vector<Judged>& judged) {
        std::vector<TimeColumn> columns = columns_of(judged, &Sight::pairs);
        columns.push_back({"rays by some depth", judged[0].found.deep_pairs});
        page.plot(Curves{.title = fmt::format("Colliding pairs, {} {}, loop {}", quality.count,
                                              quality.scene, loop),
                         .x = "time [s]",
                         .y = "colliding pairs",
                         .table = over_time(quality.time, columns)},
                  fmt::format("figure_{}_{}", figure, loop));
    };
    page.line("## Figure {}: colliding pairs in each frame, {} {}\n", figure, quality.count,
              quality.scene);
    page.line(
        "The paper: \"two curves has a high concordance\", those of rays and GJK. Bodies that only "
        "touch collide, too, but "
        "need not overlap in truth. Concordance is Lin's, 1 at best.\n");
    page.line(
        "Loop open: all on the motion that rays brought about; GJK/EPA on convex pieces, without "
        "Bullet's margin.");
    counts(quality.open, page);
    errors(quality.open, page);
    curves("open", quality.open);
    page.line(
        "Loop closed, as in the paper: each method on the motion it brought about. Bullet keeps "
        "bodies its margins apart "
        "and GJK/EPA's pairs are those whose margins overlap; the truth is that of the meshes.");
    counts(quality.closed, page);
    curves("closed", quality.closed);
}

}  // namespace pierce::app
