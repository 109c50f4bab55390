#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/measure/in_parallel.hpp"
#include "app/output/progress.hpp"
#include "app/reports/cloth/cloth_figures.hpp"
#include "scenes/named/shapes.hpp"
#include "scenes/simulate/simulation.hpp"

namespace pierce::app {
namespace {

/// What the paper leaves open about the scene of figure 16 and Algorithm 1.
struct Reading {
    std::string name;
    double dt = 1.0 / 60;
    std::uint32_t nodes = 20;
    SelfCollision how = SelfCollision::published;
    double thickness = 0.1;  ///< of the sheet [distance of its vertices]
    bool ground = true;
    bool wide_capsule = false;  ///< one on which the sheet comes to rest instead of sliding off
};

/// How deep the cloth goes through itself.
struct Depths {
    double exact = 0;     ///< [length] by its edges through its triangles
    double reported = 0;  ///< [length] by the deepest contact that the rays themselves find
    std::uint32_t frames = 0, frames_with_any = 0;
};

scenes::SceneSetup scene_of(const Reading& reading, std::uint32_t seed) {
    scenes::SceneSetup scene = scenes::make_scene("cloth-capsule",
                                                  {.seed = seed, .nodes = reading.nodes});
    const double plain = scene.bodies.back().collision.thickness;
    for (scenes::SceneBody& body : scene.bodies)
        if (body.collision.sheet) {
            body.collision.self = reading.how;
            body.collision.thickness = 10 * reading.thickness * plain;
        }
    if (!reading.ground) scene.bodies.erase(scene.bodies.begin());
    if (reading.wide_capsule)
        for (scenes::SceneMesh& mesh : scene.meshes)
            if (mesh.name == "capsule") mesh.data = scenes::capsule(1.2, 2.5, 32, 10);
    return scene;
}

Depths fall(const Reading& reading, const ClothReportOptions& options) {
    scenes::Simulation simulation(scene_of(reading, options.seed), scenes::Method::rays,
                                  {.backend = "embree", .threads = 1, .world = {}});
    const Timing timing{options.falling.seconds, reading.dt};
    Depths depths;
    for (std::uint32_t i = 0; i < timing.steps(); ++i) {
        const double depth = simulation.step(reading.dt).self_penetration;
        depths.exact = std::max(depths.exact, depth);
        depths.frames_with_any += depth > 0;
        ++depths.frames;
        for (const Contact& c : simulation.world()->contacts())
            if (c.a == c.b) depths.reported = std::max(depths.reported, c.penetration_depth());
    }
    return depths;
}

void row(Page& page, const Reading& reading, const Depths& d) {
    page.line("| {} | {:.4g} | {:.0f} | {} of {} | {:.4g} | {:.0f} |", reading.name, d.exact,
              d.exact / paper_penetration, d.frames_with_any, d.frames, d.reported,
              d.reported / paper_penetration);
}

}  // namespace

void cloth_variants_figure(const ClothReportOptions& options, Page& page) {
    page.line("### Why Algorithm 1 does not reach the paper's depth here\n");
    page.line(
        "The paper does not say how long a step is, how large capsule and cloth are, how thick "
        "cloth is, how contacts push it, nor of what its depth is measured. Each row changes one "
        "of these. *Reported* is the deepest contact that the algorithm itself finds, which is all "
        "that a program without an exact measure would see. {:g} s each.\n",
        options.falling.seconds);
    page.line(
        "| reading | deepest, exact | over the paper's {:g} | steps with any | deepest, as "
        "reported | over the paper's |\n|---|---|---|---|---|---|",
        paper_penetration);
    std::vector<Reading> readings{
        {.name = "steps of 1/60 s, 20 x 20 vertices"},
        {.name = "velocity relative to what is hit", .how = SelfCollision::rays},
        {.name = "six times as thick, as Bullet's margin is", .thickness = 0.6},
        {.name = "no ground: the cloth falls past the capsule", .ground = false},
        {.name = "a wide capsule, on which the cloth rests", .wide_capsule = true}};
    constexpr double rates[] = {60, 120, 240, 480};  // steps a second
    constexpr std::uint32_t sizes[] = {10, 20, 40};
    const std::size_t others = readings.size();
    for (const double rate : rates)
        readings.push_back({.name = fmt::format("steps of 1/{:g} s", rate), .dt = 1 / rate});
    for (const std::uint32_t nodes : sizes)
        readings.push_back({.name = fmt::format("{0} x {0} vertices", nodes), .nodes = nodes});
    std::vector<Depths> depths(readings.size());
    Progress progress("figure 16, readings", static_cast<std::uint32_t>(readings.size()));
    in_parallel("making figure 16", readings.size(), [&](std::size_t i) {
        depths[i] = fall(readings[i], options);
        progress.one_more();
    });
    for (std::size_t i = 0; i < readings.size(); ++i) row(page, readings[i], depths[i]);

    Curves by_step{.title = "Algorithm 1, depth against the time step",
                   .x = "steps a second [1/s]",
                   .y = {"depth [m]"},
                   .table = {{"steps_a_second", "exact", "reported", "paper"}, {}},
                   .log_x = true,
                   .log_y = true,
                   .lines = {{.look = "truth", .name = "exact"},
                             {.look = "published", .name = "as Algorithm 1 reports"},
                             {.look = "paper", .stroke = Stroke::dashed}}};
    for (std::size_t i = 0; i < std::size(rates); ++i) {
        const Depths& d = depths[others + i];
        by_step.table.rows.push_back({rates[i], d.exact, d.reported, paper_penetration});
    }
    Curves by_size = by_step;
    by_size.title = "Algorithm 1, depth against resolution";
    by_size.x = "vertices along a side of the cloth";
    by_size.table = {{"nodes", "exact", "reported", "paper"}, {}};
    for (std::size_t i = 0; i < std::size(sizes); ++i) {
        const Depths& d = depths[others + std::size(rates) + i];
        by_size.table.rows.push_back(
            {static_cast<double>(sizes[i]), d.exact, d.reported, paper_penetration});
    }
    page.plot(by_step, "figure_16_steps");
    page.plot(by_size, "figure_16_resolution");
}

}  // namespace pierce::app
