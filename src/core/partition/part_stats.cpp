#include "core/partition/part_stats.hpp"

#include <algorithm>
#include <cstdint>

#include "pierce/stage.hpp"

namespace pierce {
namespace {

constexpr std::uint32_t StepStats::*counts[] = {&StepStats::pairs,
                                                &StepStats::rays,
                                                &StepStats::hits,
                                                &StepStats::certified,
                                                &StepStats::looks,
                                                &StepStats::walks,
                                                &StepStats::walk_steps,
                                                &StepStats::lost_walks,
                                                &StepStats::full_passes,
                                                &StepStats::predictions,
                                                &StepStats::predictions_true,
                                                &StepStats::proofs,
                                                &StepStats::edges,
                                                &StepStats::chords,
                                                &StepStats::edge_contacts,
                                                &StepStats::inside_tests,
                                                &StepStats::separated_pairs,
                                                &StepStats::reprojected,
                                                &StepStats::self_contacts,
                                                &StepStats::triangle_pairs,
                                                &StepStats::feature_pairs,
                                                &StepStats::crossings,
                                                &StepStats::remembered,
                                                &StepStats::tangled,
                                                &StepStats::own_rays,
                                                &StepStats::contacts,
                                                &StepStats::touching_pairs,
                                                &StepStats::refits,
                                                &StepStats::rebuilds};

double time_of(const StepStats& stats, StageId stage) {
    const auto at = std::ranges::find(stats.stages, stage, &StageTime::stage);
    return at == stats.stages.end() ? 0 : at->milliseconds;
}

}  // namespace

std::span<std::uint32_t StepStats::*const> added_counts() { return counts; }

void add_parts(std::span<const StepStats> parts, StepStats& whole) {
    double depths = 0;
    for (const StepStats& part : parts) {
        whole.part_milliseconds.push_back(part.milliseconds);
        for (const auto count : counts) whole.*count += part.*count;
        whole.status |= part.status;
        whole.triangle_tests += part.triangle_tests;
        whole.device_milliseconds = std::max(whole.device_milliseconds, part.device_milliseconds);
        whole.penetration_max = std::max(whole.penetration_max, part.penetration_max);
        depths += part.penetration_mean * part.contacts;
        for (const StageTime& of_part : part.stages) {
            const double known = time_of(whole, of_part.stage);
            add_time(whole.stages, of_part.stage, std::max(of_part.milliseconds - known, 0.0));
        }
    }
    if (whole.contacts > 0) whole.penetration_mean = depths / whole.contacts;
}

}  // namespace pierce
