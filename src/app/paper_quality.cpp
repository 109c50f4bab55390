#include "app/paper_quality.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "app/statistics.hpp"
#include "app/truth_program.hpp"
#include "scenes/truth_file.hpp"

namespace pierce::app {
namespace {

using scenes::Method;
using scenes::TrueFrame;
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

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

Sight sight_of(std::string name, const FrameLog& log, const std::vector<TrueFrame>& truth) {
    Sight sight;
    sight.name = std::move(name);
    for (const TrueFrame& t : truth) {
        const scenes::FrameResult& found = log.frames()[t.frame];
        sight.pairs.push_back(static_cast<double>(found.touching.size()));
        sight.deep_pairs.push_back(static_cast<double>(found.penetrating.size()));
        sight.depth.push_back(found.penetration_mean);
        sight.missed += count_missing(t.overlapping, found.touching);
        sight.added += count_missing(found.penetrating, t.overlapping);
    }
    return sight;
}

Sight sight_of(std::string name, const std::vector<TrueFrame>& truth) {
    Sight sight;
    sight.name = std::move(name);
    for (const TrueFrame& t : truth) {
        std::vector<double> depths;
        depths.reserve(t.inside.size());
        for (const scenes::TrueVertex& v : t.inside) depths.push_back(v.depth);
        sight.pairs.push_back(static_cast<double>(t.overlapping.size()));
        sight.depth.push_back(mean(depths));
    }
    return sight;
}

}  // namespace

double Sight::missed_share(const Sight& truth) const { return share(missed, truth.pairs); }
double Sight::added_share() const { return share(added, pairs); }

Quality measure_quality(const scenes::SceneSetup& scene, Timing timing, std::uint32_t truth_every) {
    const ClosedLoop rays = simulate(scene, Method::rays, {}, timing),
                     gjk = simulate(scene, Method::gjk_epa, {}, timing);
    const FrameLog gjk_watching = watch(scene, rays.recording, Method::gjk_epa, {});
    const std::vector<TrueFrame> rays_truth = truth_of(rays.recording, truth_every),
                                 gjk_truth = truth_of(gjk.recording, truth_every);
    Quality quality{.scene = scene.name,
                    .count = static_cast<std::uint32_t>(scene.bodies.size()) - 1,
                    .time = {},
                    .open = {},
                    .closed = {}};
    for (const TrueFrame& t : rays_truth) quality.time.push_back(t.frame * timing.dt);
    // Rays see in the motion they brought about what they saw while they did.
    const Sight rays_sight = sight_of("rays", rays.log, rays_truth);
    const Sight truth = sight_of("truth", rays_truth);
    quality.open = {{rays_sight, truth}, {sight_of("GJK/EPA", gjk_watching, rays_truth), truth}};
    quality.closed = {{rays_sight, sight_of("truth of the rays' motion", rays_truth)},
                      {sight_of("GJK/EPA", gjk.log, gjk_truth),
                       sight_of("truth of GJK/EPA's motion", gjk_truth)}};
    return quality;
}

std::vector<TimeColumn> columns_of(const std::vector<Judged>& judged,
                                   std::vector<double> Sight::*number) {
    std::vector<TimeColumn> columns;
    const auto add = [&](const Sight& sight) {
        if (columns.empty() || columns.back().name != sight.name)
            columns.push_back({sight.name, sight.*number});
    };
    for (const Judged& j : judged) add(j.found);
    for (const Judged& j : judged) add(j.truth);
    return columns;
}

}  // namespace pierce::app
