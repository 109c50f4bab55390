#include "pierce/c/step.h"

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/settings.hpp"
#include "c_api/versioned.hpp"
#include "c_api/world_state.hpp"

namespace pierce::c {
namespace {

static_assert(PIERCE_BODY_EXCLUDED == body_excluded);

/// The stats without the stages.
pierce_step_stats stats_of(const StepStats& s) {
    return {.struct_size = sizeof(pierce_step_stats),
            .stages = nullptr,
            .stage_count = 0,
            .milliseconds = s.milliseconds,
            .device_milliseconds = s.device_milliseconds,
            .penetration_mean = s.penetration_mean,
            .penetration_max = s.penetration_max,
            .triangle_tests = s.triangle_tests,
            .status = s.status,
            .excluded_bodies = s.excluded_bodies,
            .pairs = s.pairs,
            .touching_pairs = s.touching_pairs,
            .contacts = s.contacts,
            .rays = s.rays,
            .hits = s.hits,
            .certified = s.certified,
            .looks = s.looks,
            .walks = s.walks,
            .walk_steps = s.walk_steps,
            .lost_walks = s.lost_walks,
            .full_passes = s.full_passes,
            .predictions = s.predictions,
            .predictions_true = s.predictions_true,
            .proofs = s.proofs,
            .rested = s.rested,
            .edges = s.edges,
            .chords = s.chords,
            .edge_contacts = s.edge_contacts,
            .inside_tests = s.inside_tests,
            .separated_pairs = s.separated_pairs,
            .reprojected = s.reprojected,
            .self_contacts = s.self_contacts,
            .triangle_pairs = s.triangle_pairs,
            .feature_pairs = s.feature_pairs,
            .crossings = s.crossings,
            .remembered = s.remembered,
            .tangled = s.tangled,
            .own_rays = s.own_rays,
            .refits = s.refits,
            .rebuilds = s.rebuilds,
            .at_rest = s.at_rest,
            .part_milliseconds = nullptr,
            .part_count = 0};
}

}  // namespace
}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_detect(pierce_world* world) {
    return guarded([&] { world_of(world).detect(); });
}

pierce_status pierce_stats(pierce_world* world, pierce_step_stats* stats) {
    return guarded([&] {
        auto& inner = world_of(world);
        check_struct(stats, "stats");
        const pierce::StepStats& last = inner.stats();
        std::vector<pierce_stage_time> times;
        times.reserve(last.stages.size());
        for (const pierce::StageTime& time : last.stages)
            times.push_back({pierce::name_of(time.stage), time.milliseconds});
        world->stage_times = std::move(times);
        pierce_step_stats result = stats_of(last);
        result.stages = world->stage_times.data();
        result.stage_count = world->stage_times.size();
        world->part_milliseconds = last.part_milliseconds;
        result.part_milliseconds = world->part_milliseconds.data();
        result.part_count = world->part_milliseconds.size();
        write_struct(result, stats);
    });
}

pierce_status pierce_plan(pierce_world* world, pierce_plan_info* plan) {
    return guarded([&] {
        auto& inner = world_of(world);
        check_struct(plan, "plan");
        decltype(world->plan) copy{};
        copy.plan = inner.plan();
        copy.settings = settings_of(copy.plan.settings);
        for (const pierce::StageId stage : copy.plan.stages)
            copy.stages.push_back(pierce::name_of(stage));
        // Strings keep their place when the list that holds them is moved.
        for (const std::string& note : copy.plan.notes) copy.notes.push_back(note.c_str());
        for (const pierce::PlannedPart& part : copy.plan.parts)
            copy.parts.push_back({.backend = part.backend.c_str(),
                                  .share = part.share,
                                  .triangles = part.triangles,
                                  .bodies = part.bodies,
                                  .ghosts = part.ghosts,
                                  .on_device = part.on_device});
        world->plan = std::move(copy);
        const auto& [made, settings, stages, notes, parts] = world->plan;
        write_struct(pierce_plan_info{.struct_size = sizeof(pierce_plan_info),
                                      .settings = &settings,
                                      .stages = stages.data(),
                                      .stage_count = stages.size(),
                                      .notes = notes.data(),
                                      .note_count = notes.size(),
                                      .revision = made.revision,
                                      .fixed_bodies = made.fixed_bodies,
                                      .rigid_bodies = made.rigid_bodies,
                                      .deforming_bodies = made.deforming_bodies,
                                      .open_bodies = made.open_bodies,
                                      .worlds = made.worlds,
                                      .excluded_pairs = made.excluded_pairs,
                                      .parts = parts.data(),
                                      .part_count = parts.size()},
                     plan);
    });
}

pierce_status pierce_body_boxes(pierce_world* world, const pierce_body_box** boxes, size_t* count) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(boxes, "boxes");
        required(count, "count");
        std::vector<pierce_body_box> found;
        for (const auto& [body, box] : inner.body_boxes()) {
            pierce_body_box& b = found.emplace_back();
            b.body = number(body);
            copy_to(b.lower, box.lower);
            copy_to(b.upper, box.upper);
        }
        world->boxes = std::move(found);
        *boxes = world->boxes.data();
        *count = world->boxes.size();
    });
}
