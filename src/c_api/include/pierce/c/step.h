/** One step: what it does, what it took. */
#ifndef PIERCE_C_STEP_H
#define PIERCE_C_STEP_H

#include "pierce/c/settings.h"

PIERCE_C_BEGIN

/** Runs one step: finds all contacts of the bodies where they are now. If nothing has changed in
 *  this step and the last one, contacts get older and nothing else is done (docs/filters.md). */
PIERCE_API pierce_status pierce_detect(pierce_world* world);

/** How long a stage took. */
typedef struct pierce_stage_time {
    const char* name;
    double milliseconds;
} pierce_stage_time;

/** A bit of pierce_step_stats::status: some body's place was unusable. */
#define PIERCE_BODY_EXCLUDED UINT32_C(1)

/** How long one step took and what it found; pierce/step_stats.hpp says more of each count. */
typedef struct pierce_step_stats {
    size_t struct_size;              /**< set by the caller: sizeof(pierce_step_stats) */
    const pierce_stage_time* stages; /**< that ran; valid until the next pierce_stats() */
    size_t stage_count;
    double milliseconds;        /**< the whole step */
    double device_milliseconds; /**< the part that a GPU repeats as a whole */
    double penetration_mean;    /**< [length] over the contacts */
    double penetration_max;
    uint64_t triangle_tests;
    uint32_t status; /**< 0: everything was done; else bits */
    uint32_t excluded_bodies;
    uint32_t pairs; /**< bodies whose boxes overlap */
    uint32_t touching_pairs;
    uint32_t contacts;
    uint32_t rays;
    uint32_t hits;
    uint32_t certified;
    uint32_t looks;
    uint32_t walks;
    uint32_t walk_steps;
    uint32_t lost_walks;
    uint32_t full_passes;
    uint32_t predictions;
    uint32_t predictions_true;
    uint32_t proofs;
    uint32_t rested;
    uint32_t edges;
    uint32_t chords;
    uint32_t edge_contacts;
    uint32_t inside_tests;
    uint32_t separated_pairs;
    uint32_t reprojected;
    uint32_t self_contacts;
    uint32_t triangle_pairs;
    uint32_t feature_pairs;
    uint32_t crossings;
    uint32_t remembered;
    uint32_t tangled;
    uint32_t own_rays;
    uint32_t refits;
    uint32_t rebuilds;
    uint32_t at_rest; /**< 1: nothing had changed, counts are those of the last step */
    const double* part_milliseconds; /**< each part's own step; valid as `stages` are */
    size_t part_count;               /**< 0 if one backend does all */
} pierce_step_stats;

/** The last step's stages, counts and status bits; `stats->struct_size` must be set. */
PIERCE_API pierce_status pierce_stats(pierce_world* world, pierce_step_stats* stats);

/** What one of the backends that share a world does. */
typedef struct pierce_planned_part {
    const char* backend; /**< for people */
    double share;        /**< of the work, as was asked for */
    uint64_t triangles;  /**< of its bodies and ghosts */
    uint32_t bodies;     /**< that it owned in the last step; 0 before the first one */
    uint32_t ghosts;     /**< bodies of other parts that were near in the last step */
    uint32_t on_device;  /**< 0, 1: it runs on a GPU */
} pierce_planned_part;

/** Which stages steps run, and which rules do not apply to some body. Valid until pierce_plan() is
 *  called again. */
typedef struct pierce_plan_info {
    size_t struct_size;              /**< set by the caller: sizeof(pierce_plan_info) */
    const pierce_settings* settings; /**< in effect: what no body needs is off */
    const char* const* stages;       /**< names, in their order */
    size_t stage_count;
    const char* const* notes; /**< a sentence for every rule that does not apply */
    size_t note_count;
    uint64_t revision; /**< changes with every new plan */
    uint32_t fixed_bodies;
    uint32_t rigid_bodies;
    uint32_t deforming_bodies;
    uint32_t open_bodies; /**< without an inside: sources only */
    uint32_t worlds;      /**< without PIERCE_ALL_WORLDS */
    uint32_t excluded_pairs;
    const pierce_planned_part* parts; /**< what runs where */
    size_t part_count;                /**< 0 if one backend does all */
} pierce_plan_info;

/** The world's plan; `plan->struct_size` must be set. */
PIERCE_API pierce_status pierce_plan(pierce_world* world, pierce_plan_info* plan);

/** A body and the box that it stands in. World space. */
typedef struct pierce_body_box {
    pierce_body_id body;
    double lower[3];
    double upper[3];
} pierce_body_box;

/** The boxes of all bodies that took part in the last step. Valid until this is called again.
 *  Errors: bodies were added, removed, moved or changed since. */
PIERCE_API pierce_status pierce_body_boxes(pierce_world* world, const pierce_body_box** boxes,
                                           size_t* count);

PIERCE_C_END

#endif
