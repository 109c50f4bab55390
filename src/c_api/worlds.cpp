#include "pierce/c/worlds.h"

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/versioned.hpp"
#include "c_api/world_state.hpp"

using namespace pierce::c;

pierce_status pierce_worlds(pierce_world* world, const int32_t** worlds, size_t* count) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(worlds, "worlds");
        required(count, "count");
        world->worlds = inner.worlds();
        *worlds = world->worlds.data();
        *count = world->worlds.size();
    });
}

pierce_status pierce_bodies_of(pierce_world* world, int32_t of, const pierce_body_id** bodies,
                               size_t* count) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(bodies, "bodies");
        required(count, "count");
        std::vector<pierce_body_id> found;
        for (const pierce::BodyId body : inner.bodies_of(of)) found.push_back(number(body));
        world->bodies = std::move(found);
        *bodies = world->bodies.data();
        *count = world->bodies.size();
    });
}

pierce_status pierce_replicate(pierce_world* world, int32_t of, uint32_t count, int32_t* first) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(first, "first");
        *first = inner.replicate(of, count);
    });
}

pierce_status pierce_copy_places(pierce_world* world, int32_t from, int32_t to) {
    return guarded([&] { world_of(world).copy_places(from, to); });
}

pierce_status pierce_remove_world(pierce_world* world, int32_t removed) {
    return guarded([&] { world_of(world).remove_world(removed); });
}

pierce_status pierce_set_world_active(pierce_world* world, int32_t of, int active) {
    return guarded([&] { world_of(world).set_world_active(of, active != 0); });
}

pierce_status pierce_world_offsets(pierce_world* world, pierce_offsets* offsets) {
    return guarded([&] {
        auto& inner = world_of(world);
        check_struct(offsets, "offsets");
        world->offsets = inner.world_offsets();
        write_struct(pierce_offsets{.struct_size = sizeof(pierce_offsets),
                                    .worlds = world->offsets.worlds.data(),
                                    .solids = world->offsets.solids.data(),
                                    .sheets = world->offsets.sheets.data(),
                                    .world_count = world->offsets.worlds.size()},
                     offsets);
    });
}
