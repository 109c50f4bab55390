#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "c_api/arguments.hpp"
#include "pierce/c/body.h"
#include "pierce/c/queries.h"
#include "pierce/c/step.h"
#include "pierce/world.hpp"

/// A world, and what its last calls have given out: each stays as it is until the same call is made
/// again.
struct pierce_world {
    explicit pierce_world(pierce::World made) : world(std::move(made)) {}

    pierce::World world;
    std::string backend;
    std::vector<std::int32_t> worlds;
    std::vector<pierce_body_id> bodies;
    pierce::WorldOffsets offsets;
    std::vector<pierce_stage_time> stage_times;
    std::vector<double> part_milliseconds;
    std::vector<pierce_body_box> boxes;
    std::vector<pierce_contact_patch> patches;
    std::vector<pierce_impact> impacts, impacts_ahead;
    std::vector<pierce_body_pair> excluded_pairs;

    struct {
        pierce::Plan plan;
        pierce_settings settings;
        std::vector<const char*> stages, notes;
        std::vector<pierce_planned_part> parts;
    } plan{};

    struct {
        pierce::Explanation answer;
        std::string text;
    } explanation;
};

namespace pierce::c {

/// The world behind a caller's pointer. Throws InputError if that is null.
inline World& world_of(pierce_world* world) { return required(world, "world").world; }
inline const World& world_of(const pierce_world* world) { return required(world, "world").world; }

}  // namespace pierce::c
