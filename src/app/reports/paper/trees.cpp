#include <algorithm>

#include "app/output/frame_log.hpp"
#include "app/output/progress.hpp"
#include "app/reports/paper/gpu_results.hpp"
#include "app/reports/paper/sections.hpp"
#include "scenes/detect/detector.hpp"

namespace pierce::app {
namespace {

struct NamedBuilder {
    const char* name;
    TreeBuilder builder;
};

constexpr NamedBuilder builders[] = {{"trbvh", TreeBuilder::trbvh},
                                     {"hlbvh", TreeBuilder::hlbvh},
                                     {"lbvh", TreeBuilder::lbvh},
                                     {"ploc", TreeBuilder::ploc}};

/// Frames of the pile on which builders are timed.
constexpr std::uint32_t shown_frames = 60;

/// Medians over frames, and the frames in which contacts are not those of the first builder.
struct TreeTimes {
    double update = 0, narrow = 0, boxes = 0;
    std::uint32_t differ = 0;
};

double stage_ms(const scenes::FrameResult& result, StageId stage) {
    double sum = 0;
    for (const StageTime& t : result.stages)
        if (t.stage == stage) sum += t.milliseconds;
    return sum;
}

TreeTimes time_trees(const scenes::Recording& recording, const scenes::RaySettings& settings,
                     std::vector<std::uint64_t>& hashes) {
    const auto detector = scenes::make_detector(scenes::scene_of(recording), scenes::Method::rays,
                                                settings);
    std::vector<double> update, narrow, boxes;
    TreeTimes times;
    for (std::uint32_t f = 0; f < recording.frame_count; ++f) {
        scenes::put_frame(*detector, recording, f);
        const scenes::FrameResult result = detector->detect();
        if (f == hashes.size()) hashes.push_back(result.hash);
        times.differ += result.hash != hashes[f];
        // The first frame builds all trees, whatever is asked for.
        if (f == 0) continue;
        update.push_back(stage_ms(result, StageId::update));
        boxes.push_back(result.update_ms - update.back());
        narrow.push_back(result.narrow_ms);
    }
    times.update = spread_of(update).median;
    times.boxes = spread_of(boxes).median;
    times.narrow = spread_of(narrow).median;
    return times;
}

/// Rows: a builder rebuilt in every step, and the same refitted.
Table time_builders(const scenes::Recording& recording, const std::string& backend,
                    const KeepTable& keep) {
    Table table{.names = {"update_ms", "narrow_ms", "total_ms", "boxes_and_pairs_ms", "differ"},
                .rows = {},
                .labels = {}};
    std::vector<std::uint64_t> hashes;
    Progress progress("table 1, " + backend, 2 * std::size(builders));
    for (const NamedBuilder& b : builders)
        for (const bool rebuild : {true, false}) {
            scenes::RaySettings settings{.backend = backend, .threads = 1, .world = vertex_rays};
            settings.world.temporal = Temporal::off;
            settings.builder = b.builder;
            settings.rebuild = rebuild;
            settings.graph = false;
            const TreeTimes t = time_trees(recording, settings, hashes);
            table.labels.push_back(std::string(b.name) + (rebuild ? ", rebuilt" : ", refitted"));
            table.rows.push_back(
                {t.update, t.narrow, t.update + t.narrow, t.boxes, static_cast<double>(t.differ)});
            keep(table);
            progress.show(static_cast<std::uint32_t>(table.rows.size()));
        }
    return table;
}

void write(const Table& table, const std::string& where, Page& page) {
    page.line("\n{}:\n", where);
    page.line(
        "| trees | updating [ms] | narrow phase [ms] | total [ms] | boxes and pairs [ms] | frames "
        "whose contacts differ |\n|---|---|---|---|---|---|");
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
        const std::vector<double>& r = table.rows[i];
        page.line("| {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:g} |", table.labels[i], r[0], r[1],
                  r[2], r[3], r[4]);
    }
}

}  // namespace

void table_1(const PaperReportOptions& options, const Pile& soft_tori, Page& page) {
    const scenes::Recording recording = thinned(soft_tori.loop.recording, shown_frames);
    page.line("\n## Table 1: trees\n");
    page.line(
        "The paper, 100 tori on a GeForce GTX 770M: TrBVH updates in 3.1 ms, traces in 56.7 ms, "
        "59.8 ms in all; HLBVH 0.7 ms, 72.0 ms, 72.7 ms.\n");
    page.line(
        "Here {} soft tori, each with a tree of its own, in {} frames of the pile; medians. "
        "*Rebuilt* makes all trees anew in every step, as the paper does; *refitted* keeps them. "
        "Stages are timed one by one.",
        options.count, recording.frame_count);
    const Table host = time_builders(recording, "bvh",
                                     [&](const Table& table) { page.csv(table, "table_1_host"); });
    write(host, "Host, one thread, our own trees", page);
    if (const auto gpu = on_gpu(options, page, "table_1_gpu", [&](const KeepTable& keep) {
            return time_builders(recording, "cuda", keep);
        }))
        write(*gpu, "GPU, the host waits after each stage", page);
}

}  // namespace pierce::app
