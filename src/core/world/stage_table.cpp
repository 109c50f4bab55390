#include "pierce/stage.hpp"

#include "pierce/plan.hpp"
#include "pierce/step_stats.hpp"

namespace pierce {
namespace {

bool always(const Plan&) { return true; }
bool casts_rays(const Plan& plan) { return plan.casts_rays; }
bool remembers(const Plan& plan) { return plan.remembers(); }
bool is_complete(const Plan& plan) { return plan.is_complete(); }
bool misses_no_overlap(const Plan& plan) { return plan.misses_no_overlap(); }

constexpr StageInfo table[] = {
    {.id = StageId::bounds,
     .name = "bounds",
     .needed = always,
     .when = "always",
     .reads = "poses, positions",
     .writes = "boxes and fitted frames of bodies",
     .page = "step.md#bounds"},
    {.id = StageId::pairs,
     .name = "pairs",
     .needed = always,
     .when = "always",
     .reads = "boxes; pairs of the last step",
     .writes = "pairs whose boxes overlap, linked to those of the last step",
     .page = "step.md#pairs"},
    {.id = StageId::sheets,
     .name = "sheets",
     .needed = [](const Plan& plan) { return plan.sheets; },
     .when = "a body is a sheet",
     .reads = "pairs; sides of the last step",
     .writes = "contacts of sheets, and their sides",
     .page = "step.md#sheets"},
    {.id = StageId::displacement,
     .name = "displacement",
     .needed = remembers,
     .when = "steps remember",
     .reads = "pairs; frames of the last step",
     .writes = "how far the bodies of each pair have moved against each other",
     .page = "memory.md#displacement"},
    {.id = StageId::vertex_cull,
     .name = "vertex_cull",
     .needed = casts_rays,
     .when = "rays are cast",
     .reads = "pairs, displacements; proofs of the last step",
     .writes = "vertices that may be inside",
     .page = "step.md#vertex_cull"},
    {.id = StageId::ray_gen,
     .name = "ray_gen",
     .needed = casts_rays,
     .when = "rays are cast",
     .reads = "vertices that may be inside; hits of the last step",
     .writes = "a ray for each, or a walk",
     .page = "step.md#ray_gen"},
    {.id = StageId::edges,
     .name = "edges",
     .needed = is_complete,
     .when = "coverage is complete",
     .reads = "pairs; near edges of the last step",
     .writes = "chords within edges, and a ray for each",
     .page = "step.md#edges"},
    {.id = StageId::walk,
     .name = "walk",
     .needed = remembers,
     .when = "steps remember",
     .reads = "walks; triangles of the last step",
     .writes = "hits of walks, full rays of lost ones",
     .page = "memory.md#walk"},
    {.id = StageId::update,
     .name = "update",
     .needed = casts_rays,
     .when = "rays are cast",
     .reads = "rays, positions",
     .writes = "trees of the bodies that rays are aimed at",
     .page = "step.md#update"},
    {.id = StageId::trace,
     .name = "trace",
     .needed = casts_rays,
     .when = "rays are cast",
     .reads = "rays, trees",
     .writes = "the triangle each ray crosses first",
     .page = "step.md#trace"},
    {.id = StageId::classify,
     .name = "classify",
     .needed = casts_rays,
     .when = "rays are cast",
     .reads = "hits",
     .writes = "candidates, and which of them are contacts",
     .page = "step.md#classify"},
    {.id = StageId::self_overlap,
     .name = "self_overlap",
     .needed = [](const Plan& plan) { return plan.meets_itself; },
     .when = "a solid is looked for in itself",
     .reads = "candidates of solids in themselves",
     .writes = "which of them are contacts",
     .page = "step.md#self_overlap"},
    {.id = StageId::reproject,
     .name = "reproject",
     .needed = [](const Plan& plan) { return plan.reprojects; },
     .when = "contacts end at the closest point, or a sheet meets a solid",
     .reads = "candidates that are contacts, trees",
     .writes = "the closest point of the target's surface",
     .page = "step.md#reproject"},
    {.id = StageId::separation,
     .name = "separation",
     .needed = misses_no_overlap,
     .when = "coverage is complete or overlaps",
     .reads = "candidates, chords; near edges of the last step",
     .writes = "contacts of pairs that overlap and have none so far",
     .page = "step.md#separation"},
    {.id = StageId::margin,
     .name = "margin",
     .needed = [](const Plan& plan) { return plan.margins; },
     .when = "a solid has a margin",
     .reads = "pairs, trees",
     .writes = "contacts with a positive distance",
     .page = "step.md#margin"},
    {.id = StageId::contacts,
     .name = "contacts",
     .needed = casts_rays,
     .when = "rays are cast",
     .reads = "candidates that are contacts; ages of the last step",
     .writes = "the sorted list of contacts",
     .page = "step.md#contacts"},
    {.id = StageId::remember,
     .name = "remember",
     .needed = remembers,
     .when = "steps remember",
     .reads = "hits",
     .writes = "what the next step needs to know, and proofs that vertices are outside",
     .page = "memory.md#remember"},
    {.id = StageId::statistics,
     .name = "statistics",
     .needed = always,
     .when = "always",
     .reads = "all lists",
     .writes = "counts of the step",
     .page = "step.md#statistics"}};

constexpr bool is_in_order() {
    for (std::size_t i = 0; i < std::size(table); ++i)
        if (static_cast<std::size_t>(table[i].id) != i) return false;
    return true;
}
static_assert(is_in_order() && table[std::size(table) - 1].id == StageId::statistics);

}  // namespace

std::span<const StageInfo> stage_table() { return table; }

const char* name_of(StageId stage) { return table[static_cast<std::size_t>(stage)].name; }

void add_time(std::vector<StageTime>& times, StageId stage, double milliseconds) {
    const auto at = std::ranges::lower_bound(times, stage, {}, &StageTime::stage);
    if (at != times.end() && at->stage == stage)
        at->milliseconds += milliseconds;
    else
        times.insert(at, {stage, milliseconds});
}

}  // namespace pierce
