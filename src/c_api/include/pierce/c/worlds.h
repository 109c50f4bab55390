/** Worlds within a world: many small scenes that know nothing of each other (docs/filters.md). */
#ifndef PIERCE_C_WORLDS_H
#define PIERCE_C_WORLDS_H

#include "pierce/c/base.h"

PIERCE_C_BEGIN

/** The worlds that bodies are in, sorted, without PIERCE_ALL_WORLDS. Valid until this is called
 *  again. */
PIERCE_API pierce_status pierce_worlds(pierce_world* world, const int32_t** worlds, size_t* count);
/** The bodies of one of them, in the order in which contacts are sorted. Valid until this is called
 *  again. */
PIERCE_API pierce_status pierce_bodies_of(pierce_world* world, int32_t of,
                                          const pierce_body_id** bodies, size_t* count);
/** Copies all bodies of one into `count` new ones, which follow each other, and gives the first.
 *  Errors: no bodies, too many worlds or bodies. */
PIERCE_API pierce_status pierce_replicate(pierce_world* world, int32_t of, uint32_t count,
                                          int32_t* first);
/** Puts the bodies of `to` where those of `from` are. Errors: worlds that differ. */
PIERCE_API pierce_status pierce_copy_places(pierce_world* world, int32_t from, int32_t to);
/** Removes all bodies of one. Errors: PIERCE_ALL_WORLDS. */
PIERCE_API pierce_status pierce_remove_world(pierce_world* world, int32_t removed);
/** Leaves the bodies of one out of steps (`active` 0), or takes them in again. Errors:
 *  PIERCE_ALL_WORLDS, a world without bodies. */
PIERCE_API pierce_status pierce_set_world_active(pierce_world* world, int32_t of, int active);

/** Which contacts are of which world. Those of worlds[i] are the contacts from solids[i] to
 *  solids[i + 1], and from sheets[i] to sheets[i + 1]. Valid until pierce_world_offsets() is called
 *  again. */
typedef struct pierce_offsets {
    size_t struct_size; /**< set by the caller: sizeof(pierce_offsets) */
    const int32_t* worlds;
    const uint32_t* solids; /**< world_count + 1, like the next one */
    const uint32_t* sheets;
    size_t world_count;
} pierce_offsets;

/** Which of the last step's contacts are of which world; `offsets->struct_size` must be set.
 *  Errors: bodies were added, removed, moved or changed since. */
PIERCE_API pierce_status pierce_world_offsets(pierce_world* world, pierce_offsets* offsets);

PIERCE_C_END

#endif
