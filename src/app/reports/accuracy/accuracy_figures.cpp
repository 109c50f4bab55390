#include "app/reports/accuracy/accuracy_figures.hpp"

#include <array>
#include <cmath>
#include <map>
#include <ranges>
#include <utility>
#include <vector>

#include "app/measure/compare.hpp"
#include "app/output/frame_log.hpp"
#include "app/output/progress.hpp"
#include "app/output/waiting.hpp"
#include "app/reports/accuracy/random_poses.hpp"
#include "scenes/measure/leaks.hpp"
#include "scenes/named/shapes.hpp"

namespace pierce::app {
namespace {

using scenes::Aim;
using scenes::Recording;

std::vector<Comparison> compare_methods(const Recording& recording, bool pairs_only,
                                        std::initializer_list<const char*> names,
                                        const std::string& what) {
    std::vector<ComparedMethod> methods;
    for (const char* name : names) methods.push_back(compared_method_named(name));
    return compare(recording, truth_of(recording, 1, pairs_only), methods, 1, what);
}

double mean_edge(const MeshData& data) { return Mesh("sphere", data).traits().mean_edge_length; }

/// How far a sphere of radius 1 reaches beyond the middles of its mesh's triangles at most.
double cut_off(const MeshData& sphere) {
    double least = 1;
    for (const Triangle& t : sphere.triangles) {
        Vec3d sum;
        for (std::uint32_t v : t.vertex) sum += to_double(sphere.positions[v]);
        least = std::min(least, length(sum) / 3);
    }
    return 1 - least;
}

std::string kernel_name(const scenes::LeakCount& count) {
    return count.kernel + (count.fma ? " with fma" : "");
}

Line kernel_line(const scenes::LeakCount& count) {
    return {.look = count.kernel,
            .note = count.fma ? "with fma" : "",
            .stroke = count.fma ? Stroke::dashed : Stroke::solid};
}

}  // namespace

Scatter speed_against_error(const Table& figures, const std::string& title) {
    Scatter plot{.title = title,
                 .x = "time a frame [ms]",
                 .y = {"overlapping pairs missed [%]", "depth missed [%]"},
                 .corner = "↙ left and down is better: fast, and nothing missed",
                 .points = {},
                 .table = figures};
    for (std::size_t r = 0; r < figures.rows.size(); ++r) {
        const std::string& name = figures.labels[r];
        const double pairs = std::max(figures.number(r, "pairs"), 1.0);
        plot.points.push_back({.look = name,
                               .x = figures.number(r, "ms"),
                               .y = {100 * figures.number(r, "missed_pairs") / pairs,
                                     100 * figures.number(r, "missed_depth_share")},
                               .stands_out = name == default_method});
    }
    return plot;
}

void leaks_figure(const AccuracyReportOptions& options, Page& page) {
    const std::size_t kernel_rays = options.rays / 50;
    page.line("## Leaks over the offset from the origin\n");
    page.line(
        "Rays from inside a ball of 1280 triangles at its vertices and edges. A ray that meets "
        "nothing has leaked.\n");
    page.line("| the library's tracer (Embree), offset | at | rays | leaks |\n|---|---|---|---|");
    for (double offset : {0.0, 1e5})
        for (Aim aim : {Aim::vertices, Aim::edges}) {
            const Waiting waiting("leaks of the tracers");
            const scenes::LeakCount count = scenes::count_tracer_leaks(offset, aim,
                                                                       options.rays / 4);
            page.line("| {:g} | {} | {} | {} |", offset,
                      aim == Aim::vertices ? "vertices" : "edges", count.rays, count.leaks);
        }
    for (Aim aim : {Aim::vertices, Aim::edges}) {
        const std::string at = aim == Aim::vertices ? "vertices" : "edges";
        Curves curves{.title = "Rays lost at " + at,
                      .x = "offset from the origin [ball of radius 16]",
                      .y = {"lost rays [%]"},
                      .table = {},
                      .log_x = true,
                      .log_y = true};
        curves.table.names.emplace_back("offset");
        std::map<std::string, std::array<std::size_t, 3>> sums;  // rays, lost in all, lost at the
                                                                 // origin
        const std::vector<double> offsets = scenes::leak_offsets();
        Progress progress("leaks at " + at, static_cast<std::uint32_t>(offsets.size()));
        std::uint32_t done = 0;
        for (double offset : offsets) {
            std::vector<double> row{offset};
            for (const scenes::LeakCount& count :
                 scenes::count_kernel_leaks(offset, aim, kernel_rays)) {
                if (offset == 0) {
                    curves.table.names.push_back(kernel_name(count));
                    curves.lines.push_back(kernel_line(count));
                }
                row.push_back(100 * count.share());
                auto& sum = sums[kernel_name(count)];
                sum[0] += count.rays;
                sum[1] += count.leaks;
                if (offset == 0) sum[2] = count.leaks;
            }
            curves.table.rows.push_back(std::move(row));
            progress.show(++done);
        }
        page.line(
            "\n| triangle test, rays at {} | lost at the origin, of {} | lost at all {} offsets | "
            "of |",
            at, kernel_rays, offsets.size());
        page.line("|---|---|---|---|");
        for (const auto& [name, sum] : sums)
            page.line("| {} | {} | {} | {} |", name, sum[2], sum[1], sum[0]);
        const std::string name = "f6_leaks_" + at;
        page.plot(curves, name);
    }
}

void resolution_figure(const AccuracyReportOptions& options, Page& page) {
    // So many parts of an icosahedron's edges: each with the finest, either way around.
    constexpr std::uint32_t finest = 12;
    constexpr std::uint32_t parts[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ratios;
    for (std::uint32_t n : parts) ratios.emplace_back(finest, n);
    ratios.emplace_back(finest, finest);
    for (std::uint32_t n : parts | std::views::reverse) ratios.emplace_back(n, finest);
    // There are many: each has half of the poses.
    const std::uint32_t poses = (options.poses + 1) / 2;
    page.line("## Overlaps missed over the ratio of resolutions\n");
    page.line(
        "Two spheres of radius 1, {} random poses per ratio. They overlap no deeper than by about "
        "as much as their",
        poses);
    page.line("triangles cut off from the ball.\n");
    page.line(
        "| mean edges, first : second | triangles | overlapping pairs | missed by vertices [%] | "
        "overlaps [%] | complete [%] | gjk-hull [%] | gimpact [%] | false pairs, in this order "
        "|\n|---|---|---|---|---|---|---|---|---|");
    Curves curves{
        .title = "Overlapping pairs missed",
        .x = "mean edge length, first sphere : second sphere",
        .y = {"missed [%]"},
        .table = {{"ratio", "vertices", "overlaps", "complete", "gjk-hull", "gimpact"}, {}},
        .log_x = true,
        .log_y = true,
        .lines = {}};
    const std::initializer_list<const char*> methods{"full", "overlaps", "complete", "gjk-hull",
                                                     "gimpact"};
    for (const char* name : methods) curves.lines.push_back({.look = name});
    std::uint32_t seed = options.seed;
    for (const auto& [in_first, in_second] : ratios) {
        const MeshData first = scenes::geodesic_sphere(1, in_first),
                       second = scenes::geodesic_sphere(1, in_second);
        const double cut = cut_off(first) + cut_off(second);
        const Recording recording = random_pairs(first, second, 2 - 2 * cut, 2, poses, seed++);
        const std::vector<Comparison> results = compare_methods(
            recording, true, methods, fmt::format("resolutions {} : {}", in_first, in_second));
        const double ratio = mean_edge(first) / mean_edge(second);
        curves.table.rows.push_back({ratio});
        std::string missed, falses;
        for (const Comparison& c : results) {
            curves.table.rows.back().push_back(100 * c.accuracy.missed_pairs_share());
            missed += fmt::format(" {:.2f} |", curves.table.rows.back().back());
            falses += fmt::format("{}{}", falses.empty() ? "" : ", ", c.accuracy.false_pairs);
        }
        page.line("| {:.3g} | {} : {} | {} |{} {} |", ratio, first.triangles.size(),
                  second.triangles.size(), results[0].accuracy.pairs, missed, falses);
    }
    page.plot(curves, "f7_resolution");
}

void depth_figure(const AccuracyReportOptions& options, Page& page) {
    constexpr int levels = 4;
    constexpr std::uint32_t poses = 8;
    const MeshData ball = scenes::sphere(1, levels);
    page.line("## Depth over overlap\n");
    page.line(
        "Two spheres of radius 1 and {} triangles, each overlap in {} random poses: depth of every "
        "contact over the "
        "distance "
        "of its vertex to the other surface.\nGJK/EPA on the hulls names no vertices: its depth is "
        "that of the pair, over "
        "that of the deepest vertex.\n",
        ball.triangles.size(), poses);
    page.line(
        "| overlap / diameter [%] | vertices inside | inward rays, median | p95 | max | "
        "re-projected, median | p95 | max | "
        "EPA |\n|---|---|---|---|---|---|---|---|---|");
    Curves curves{
        .title = "Depth of two equal spheres",
        .x = "overlap / diameter [%]",
        .y = {"depth / true local depth"},
        .table = {{"overlap_percent", "inward rays median", "inward rays p95",
                   "re-projected median", "re-projected p95", "EPA on hulls"},
                  {}},
        .lines = {
            {.look = "full", .name = "inward rays, median"},
            {.look = "full", .name = "inward rays, 95th percentile", .stroke = Stroke::dashed},
            {.look = "reprojected", .name = "re-projected, median"},
            {.look = "reprojected",
             .name = "re-projected, 95th percentile",
             .stroke = Stroke::dashed},
            {.look = "gjk-hull", .name = "EPA on hulls"}}};
    const std::initializer_list<const char*> methods{"full", "reprojected", "gjk-hull"};
    for (double overlap : {2.5, 5.0, 10.0, 15.0, 20.0, 25.0}) {
        const double distance = 2 - 2 * overlap / 100;
        const Recording recording = random_pairs(ball, ball, distance, distance, poses,
                                                 options.seed);
        const std::vector<Comparison> results = compare_methods(
            recording, false, methods, fmt::format("overlap {:g} %", overlap));
        const Spread ray = spread_of(results[0].accuracy.depth_ratios),
                     moved = spread_of(results[1].accuracy.depth_ratios);
        const double epa = results[2].accuracy.pair_depth_ratio();
        curves.table.rows.push_back({overlap, ray.median, ray.p95, moved.median, moved.p95, epa});
        page.line("| {:g} | {} | {:.3f} | {:.3f} | {:.3f} | {:.4f} | {:.4f} | {:.4f} | {:.4f} |",
                  overlap, results[0].accuracy.vertices, ray.median, ray.p95, ray.max, moved.median,
                  moved.p95, moved.max, epa);
    }
    page.plot(curves, "f9_depth");

    page.line(
        "Two tori or bunnies in {} random poses, at a distance of so many diameters of the balls "
        "around them:\n",
        options.poses);
    page.line(
        "| | distance | vertices inside | inward rays, median | p95 | max | re-projected, median | "
        "p95 | max |\n"
        "|---|---|---|---|---|---|---|---|---|");
    for (const char* name : {"tori", "bunnies"}) {
        const MeshData mesh = scenes::make_scene(name, {1, false, 1}).meshes[1].data;
        double diameter = 0;
        for (Vec3f p : mesh.positions) diameter = std::max(diameter, 2 * length(to_double(p)));
        for (const auto& [nearest, farthest] : {std::pair{0.05, 0.5}, {0.5, 0.75}, {0.75, 1.0}}) {
            const std::vector<Comparison> results = compare_methods(
                random_pairs(mesh, mesh, nearest * diameter, farthest * diameter, options.poses,
                             options.seed),
                false, {"full", "reprojected"}, fmt::format("depth of {}", name));
            const Spread ray = spread_of(results[0].accuracy.depth_ratios),
                         moved = spread_of(results[1].accuracy.depth_ratios);
            page.line(
                "| {} | {:g} to {:g} | {} | {:.3f} | {:.3f} | {:.3f} | {:.4f} | {:.4f} | {:.4f} |",
                name, nearest, farthest, results[0].accuracy.vertices, ray.median, ray.p95, ray.max,
                moved.median, moved.p95, moved.max);
        }
    }
    page.line("");
}

}  // namespace pierce::app
