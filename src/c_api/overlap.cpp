#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/contacts.hpp"
#include "c_api/versioned.hpp"
#include "c_api/world_state.hpp"
#include "pierce/c/queries.h"

namespace pierce::c {
namespace {

pierce_contact_patch patch_of(const ContactPatch& p) {
    pierce_contact_patch patch{};
    patch.area = p.area;
    patch.depth_volume = p.depth_volume;
    copy_to(patch.center, p.center);
    copy_to(patch.normal, p.normal);
    patch.depth = p.depth;
    copy_to(patch.deepest, p.deepest);
    return patch;
}

/// The overlap without its patches.
pierce_common_volume volume_of(const Overlap& overlap) {
    pierce_common_volume common{};
    common.volume = overlap.volume;
    copy_to(common.center, overlap.center);
    common.area_a = overlap.area_a;
    common.area_b = overlap.area_b;
    copy_to(common.push, overlap.push);
    copy_to(common.turn, overlap.turn);
    common.exists = 1;
    return common;
}

pierce_impact impact_of(const ImpactContact& i) {
    pierce_impact impact{};
    impact.a = number(i.a);
    impact.b = number(i.b);
    impact.time = i.time;
    copy_to(impact.point, i.point);
    copy_to(impact.normal, i.normal);
    impact.gap = i.gap;
    impact.edges = i.edges;
    impact.source = static_cast<std::uint32_t>(i.source);
    impact.vertex = i.vertex;
    impact.edge_end = i.edge_end;
    impact.triangle = i.triangle;
    copy_to(impact.start_a, i.start_a);
    copy_to(impact.start_b, i.start_b);
    return impact;
}

/// Keeps the list in the world until the same call is made again.
void give(std::vector<pierce_impact>& kept, const std::vector<ImpactContact>& found,
          const pierce_impact** impacts, std::size_t* count) {
    std::vector<pierce_impact> list;
    list.reserve(found.size());
    for (const ImpactContact& impact : found) list.push_back(impact_of(impact));
    kept = std::move(list);
    *impacts = kept.data();
    *count = kept.size();
}

}  // namespace
}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_parting(pierce_world* world, pierce_body_id a, pierce_body_id b,
                             pierce_translation* translation) {
    return guarded([&] {
        auto& inner = world_of(world);
        check_struct(translation, "translation");
        write_translation(inner.parting(body_handle(a), body_handle(b)), translation);
    });
}

pierce_status pierce_overlap(pierce_world* world, pierce_body_id a, pierce_body_id b,
                             double same_direction, pierce_common_volume* common) {
    return guarded([&] {
        auto& inner = world_of(world);
        check_struct(common, "common");
        const auto overlap = inner.overlap(body_handle(a), body_handle(b), same_direction);
        std::vector<pierce_contact_patch> patches;
        if (overlap)
            for (const pierce::ContactPatch& patch : overlap->patches)
                patches.push_back(patch_of(patch));
        world->patches = std::move(patches);
        pierce_common_volume result = overlap ? volume_of(*overlap) : pierce_common_volume{};
        result.patches = world->patches.data();
        result.patch_count = world->patches.size();
        write_struct(result, common);
    });
}

pierce_status pierce_impacts(pierce_world* world, uint32_t most_per_pair,
                             const pierce_impact** impacts, size_t* count) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(impacts, "impacts");
        required(count, "count");
        give(world->impacts, inner.impacts(most_per_pair), impacts, count);
    });
}

pierce_status pierce_impacts_ahead(pierce_world* world, const pierce_body_id* bodies,
                                   size_t body_count, const double* poses, uint32_t most_per_pair,
                                   const pierce_impact** impacts, size_t* count) {
    return guarded([&] {
        auto& inner = world_of(world);
        const auto handles = body_handles(bodies, body_count, "bodies");
        if (body_count > 0) required(poses, "poses");
        required(impacts, "impacts");
        required(count, "count");
        std::vector<pierce::PoseAhead> ahead;
        ahead.reserve(handles.size());
        for (std::size_t i = 0; i < handles.size(); ++i)
            ahead.push_back({handles[i], pose_of(poses + 7 * i, "poses")});
        give(world->impacts_ahead, inner.impacts_ahead(ahead, most_per_pair), impacts, count);
    });
}
