#include "app/reports/paper/quality.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <ranges>

#include "app/measure/in_parallel.hpp"
#include "app/measure/truth_program.hpp"
#include "app/output/statistics.hpp"
#include "scenes/files/truth_file.hpp"

namespace pierce::app {
namespace {

using scenes::FrameResult;
using scenes::Method;
using scenes::TrueFrame;
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// [length] The margin around Bullet's shapes in the run with small ones: a fortieth of Bullet's
/// own, and a 500th of the radius of a torus' tube.
constexpr double small_margin = 0.001;

/// How many of the first are not among the second; both sorted.
std::uint64_t count_missing(const Pairs& from, const Pairs& in) {
    Pairs missing;
    std::ranges::set_difference(from, in, std::back_inserter(missing));
    return missing.size();
}

/// Of a sum of counts.
double share(std::uint64_t part, const std::vector<double>& counts) {
    const double all = std::accumulate(counts.begin(), counts.end(), 0.0);
    return all > 0 ? static_cast<double>(part) / all : 0;
}

Sight sight_of(std::string name, Line line, const FrameLog& log,
               const std::vector<TrueFrame>& truth) {
    Sight sight;
    sight.name = std::move(name);
    sight.line = std::move(line);
    for (const TrueFrame& t : truth) {
        const FrameResult& found = log.frames()[t.frame];
        sight.pairs.push_back(static_cast<double>(found.touching.size()));
        sight.deep_pairs.push_back(static_cast<double>(found.penetrating.size()));
        sight.depth.push_back(found.penetration_mean);
        sight.missed += count_missing(t.overlapping, found.touching);
        sight.added += count_missing(found.penetrating, t.overlapping);
    }
    return sight;
}

Sight truth_sight(std::string name, Stroke stroke, const std::vector<TrueFrame>& truth) {
    Sight sight;
    sight.name = std::move(name);
    sight.line = {.look = "truth", .stroke = stroke};
    for (const TrueFrame& t : truth) {
        std::vector<double> depths;
        depths.reserve(t.inside.size());
        for (const scenes::TrueVertex& v : t.inside) depths.push_back(v.depth);
        sight.pairs.push_back(static_cast<double>(t.overlapping.size()));
        sight.depth.push_back(mean(depths));
    }
    return sight;
}

/// Means, without the first frame, in which meshes are prepared.
StepTimes times_of(const FrameLog& log, const std::vector<TrueFrame>& truth) {
    StepTimes sum;
    const auto timed = [](const TrueFrame& t) { return t.frame > 0; };
    const auto frames = static_cast<double>(
        std::max<std::ptrdiff_t>(std::ranges::count_if(truth, timed), 1));
    for (const TrueFrame& t : truth | std::views::filter(timed)) {
        const FrameResult& f = log.frames()[t.frame];
        sum.update += f.update_ms / frames;
        sum.narrow += f.narrow_ms / frames;
        sum.response += f.response_ms / frames;
        sum.total += f.total_ms / frames;
    }
    return sum;
}

/// A motion that GJK/EPA brings about: what Bullet counts as touching, and what overlaps without
/// margins, drawn with this stroke.
std::vector<Judged> close_loop(const scenes::SceneSetup& scene, const std::string& name,
                               Stroke stroke, Timing timing, std::uint32_t truth_every) {
    const ClosedLoop loop = simulate(scene, Method::gjk_epa, {}, timing);
    const std::vector<TrueFrame> truth = truth_of(loop.recording, truth_every);
    const Sight known = truth_sight("truth of " + name, stroke, truth);
    const FrameLog watching = watch(scene, loop.recording, Method::gjk_epa, {});
    return {
        {sight_of(name + ", margins count", {.look = "gjk-epa"}, loop.log, truth), known},
        {sight_of(name + ", what overlaps", {.look = "gjk-epa", .stroke = stroke}, watching, truth),
         known}};
}

}  // namespace

double Sight::missed_share(const Sight& truth) const { return share(missed, truth.pairs); }
double Sight::added_share() const { return share(added, pairs); }

Quality measure_quality(const scenes::SceneSetup& scene, bool soft, const ClosedLoop& loop,
                        Timing timing, std::uint32_t truth_every) {
    const Method method = soft ? Method::gimpact : Method::gjk_epa;
    const FrameLog watching = watch(scene, loop.recording, method, {});
    // Rays see in the motion they brought about what they saw while they did, but for soft bodies,
    // which Bullet moves on before it looks for contacts.
    FrameLog own;
    if (soft) own = watch(scene, loop.recording, Method::rays, vertex_rays, 1);
    const FrameLog& log = soft ? own : loop.log;
    const std::vector<TrueFrame> known = truth_of(loop.recording, truth_every);
    Quality quality{
        .scene = fmt::format("{} {}{}", scene.bodies.size() - 1, soft ? "soft " : "", scene.name),
        .opponent = soft ? "GImpact" : "GJK/EPA",
        .file = scene.name + (soft ? "_soft" : ""),
        .soft = soft,
        .time = {},
        .open = {},
        .closed = {},
        .rays = times_of(log, known),
        .against = times_of(watching, known)};
    // The response is that of the run in which rays moved the bodies.
    const double response = times_of(loop.log, known).response;
    quality.rays.total += response - quality.rays.response;
    quality.rays.response = response;
    for (const TrueFrame& t : known) quality.time.push_back(t.frame * timing.dt);
    const Sight rays = sight_of("rays", {.look = "full"}, log, known),
                truth = truth_sight("truth", Stroke::solid, known);
    const Line opponent{.look = soft ? "gimpact" : "gjk-epa"};
    quality.open = {{rays, truth}, {sight_of(quality.opponent, opponent, watching, known), truth}};
    quality.closed = {{rays, truth}};
    if (soft) return quality;
    scenes::SceneSetup near = scene;
    near.baseline_margin = small_margin;
    std::vector<Judged> usual, small;
    in_parallel("closing the loop by other methods", 2, [&](std::size_t i) {
        if (i == 0)
            usual = close_loop(scene, "GJK/EPA", Stroke::dashed, timing, truth_every);
        else
            small = close_loop(near, fmt::format("GJK/EPA, margins of {:g}", small_margin),
                               Stroke::dotted, timing, truth_every);
    });
    quality.closed.insert(quality.closed.end(), {usual[0], usual[1], small[1]});
    return quality;
}

std::vector<TimeColumn> columns_of(const std::vector<Judged>& judged,
                                   std::vector<double> Sight::*number) {
    std::vector<TimeColumn> columns;
    const auto add = [&](const Sight& sight) {
        if (std::ranges::find(columns, sight.name, &TimeColumn::name) == columns.end())
            columns.push_back({sight.name, sight.*number, sight.line});
    };
    for (const Judged& j : judged) add(j.found);
    for (const Judged& j : judged) add(j.truth);
    return columns;
}

}  // namespace pierce::app
