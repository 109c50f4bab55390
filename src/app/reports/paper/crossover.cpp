#include <chrono>

#include "app/output/frame_log.hpp"
#include "app/output/progress.hpp"
#include "app/reports/paper/gpu_results.hpp"
#include "app/reports/paper/sections.hpp"
#include "pierce/contact_hash.hpp"
#include "scenes/detect/detector.hpp"
#include "scenes/recording/lattice.hpp"

namespace pierce::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t frames = 16, warm_up = 16, steps = 96;

double milliseconds_since(Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// Medians of the same steps.
struct Times {
    double put = 0;    ///< positions are set
    double step = 0;   ///< detect()
    double fetch = 0;  ///< contacts(), read for the first time
    std::vector<std::uint64_t> hashes;
};

Times time_steps(const scenes::Recording& recording, const std::string& backend, int threads) {
    scenes::RaySettings settings{.backend = backend, .threads = threads, .world = vertex_rays};
    settings.world.temporal = Temporal::off;
    const auto detector = scenes::make_detector(scenes::scene_of(recording), scenes::Method::rays,
                                                settings);
    World& world = *detector->world();
    std::vector<double> put, step, fetch;
    Times times;
    for (std::uint32_t i = 0; i < warm_up + steps; ++i) {
        const auto begin = Clock::now();
        scenes::put_frame(*detector, recording, i % frames);
        const double putting = milliseconds_since(begin);
        const auto stepped = Clock::now();
        world.detect();
        const double stepping = milliseconds_since(stepped);
        const auto fetched = Clock::now();
        const std::span<const Contact> contacts = world.contacts();
        const double fetching = milliseconds_since(fetched);
        times.hashes.push_back(contact_hash(contacts));
        if (i < warm_up) continue;
        put.push_back(putting);
        step.push_back(stepping);
        fetch.push_back(fetching);
    }
    times.put = spread_of(put).median;
    times.step = spread_of(step).median;
    times.fetch = spread_of(fetch).median;
    return times;
}

Table measure(const KeepTable& keep) {
    Table table{.names = {"tori", "triangles", "embree_1_ms", "embree_all_ms", "cuda_ms",
                          "cuda_fetch_ms", "put_embree_ms", "put_cuda_ms", "differ"},
                .rows = {},
                .labels = {}};
    constexpr std::uint32_t counts[] = {2, 4, 8, 16, 32, 64, 128, 256, 1024};
    Progress progress("crossover", std::size(counts));
    for (const std::uint32_t count : counts) {
        const scenes::Recording recording = scenes::lattice(count, frames,
                                                            scenes::LatticeMotion::soft);
        const Times one = time_steps(recording, "embree", 1),
                    all = time_steps(recording, "embree", 0),
                    cuda = time_steps(recording, "cuda", 1);
        double differ = 0;
        for (std::size_t i = 0; i < one.hashes.size(); ++i)
            differ += one.hashes[i] != cuda.hashes[i] || all.hashes[i] != cuda.hashes[i];
        table.rows.push_back({static_cast<double>(count), 600.0 * count, one.step, all.step,
                              cuda.step, cuda.fetch, all.put, cuda.put, differ});
        keep(table);
        progress.show(static_cast<std::uint32_t>(table.rows.size()));
    }
    return table;
}

}  // namespace

void crossover(const PaperReportOptions& options, Page& page) {
    page.line("\n## GPU against CPU\n");
    page.line(
        "Soft tori in a grid, positions set from the host in every step. Both have seen {} steps "
        "before; medians of the same {} steps, `detect()` as its caller sees it. Contacts are in "
        "the host's memory after a step of Embree; a GPU fetches them when they are asked for. No "
        "step remembers the last one.",
        warm_up, steps);
    const auto table = on_gpu(options, page, "crossover", measure);
    if (!table) return;
    page.line(
        "\n| tori | triangles | Embree, 1 thread [ms] | Embree, all threads [ms] | GPU [ms] | "
        "fetching contacts [ms] | setting positions: Embree, GPU [ms] | steps that differ "
        "|\n|---|---|---|---|---|---|---|---|");
    for (const std::vector<double>& r : table->rows)
        page.line("| {:g} | {:g} | {:.4f} | {:.4f} | {:.4f} | {:.4f} | {:.4f}, {:.4f} | {:g} |",
                  r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]);
}

}  // namespace pierce::app
