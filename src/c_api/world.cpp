#include "pierce/c/world.h"

#include <string>

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/settings.hpp"
#include "c_api/world_state.hpp"

using namespace pierce::c;

pierce_status pierce_create_world(const pierce_settings* settings,
                                  const pierce_backend_options* backend, pierce_world** world) {
    return guarded([&] {
        required(world, "world");
        *world = new pierce_world(pierce::World(backend_of(backend), settings_of(settings)));
    });
}

void pierce_destroy_world(pierce_world* world) { delete world; }

pierce_status pierce_backend(pierce_world* world, const char** description) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(description, "description");
        world->backend = inner.backend();
        *description = world->backend.c_str();
    });
}
