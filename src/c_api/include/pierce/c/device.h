/** Places and contacts in a GPU's memory (docs/gpu.md). All calls fail with PIERCE_INVALID_INPUT
 *  unless the world's backend runs there. */
#ifndef PIERCE_C_DEVICE_H
#define PIERCE_C_DEVICE_H

#include "pierce/c/contact.h"

PIERCE_C_BEGIN

/** Takes the positions of deforming bodies from device memory: x, y, z of every vertex, of one body
 *  after the other. Every step reads them there until others are set. Errors: a world with a sheet.
 */
PIERCE_API pierce_status pierce_set_device_positions(pierce_world* world,
                                                     const pierce_body_id* bodies,
                                                     size_t body_count, const float* positions);
/** The same for both ends of the step, of one body; worlds with sheets need both. */
PIERCE_API pierce_status pierce_set_device_motion(pierce_world* world, pierce_body_id body,
                                                  const float* start, const float* positions);
/** Takes the poses of fixed and rigid bodies from device memory, seven numbers each, as for
 *  pierce_set_poses(). Errors: a body that deforms, a world with a sheet. */
PIERCE_API pierce_status pierce_set_device_poses(pierce_world* world, const pierce_body_id* bodies,
                                                 size_t body_count, const double* poses);
PIERCE_API pierce_status pierce_set_device_poses_float(pierce_world* world,
                                                       const pierce_body_id* bodies,
                                                       size_t body_count, const float* poses);
/** Names the cudaStream_t that steps wait for, and that waits for steps. Null: none. */
PIERCE_API pierce_status pierce_set_stream(pierce_world* world, void* stream);

/** A list of contacts in device memory, as records and as arrays. All pointers are to device
 *  memory, and null where there is no room. */
typedef struct pierce_device_contact_list {
    size_t struct_size;    /**< set by the caller: sizeof(pierce_device_contact_list) */
    const uint32_t* count; /**< one number: how many contacts there are */
    const pierce_contact* records;
    const uint32_t* body_a; /**< the lower 32 bits of pierce_contact::a, like the next one of b */
    const uint32_t* body_b;
    const uint64_t* feature;
    const float* distance;
    const float* point_a; /**< three numbers each, like the next two */
    const float* point_b;
    const float* normal;
    const uint32_t* world_begins; /**< where each world's contacts begin; null without worlds */
    uint32_t room;                /**< there are never more */
    uint32_t stride;              /**< [byte] from one of `records` to the next */
} pierce_device_contact_list;

/** The last step's contacts in device memory, of solids and of sheets; the struct_size of both must
 *  be set. Waits for nothing if pierce_set_stream() was called, else until they are there. `part`:
 *  with several devices, the one that has found them; else 0. Valid until the next pierce_detect().
 *  Errors: no such part; bodies were added, removed, moved or changed since. */
PIERCE_API pierce_status pierce_device_contacts(const pierce_world* world, uint32_t part,
                                                pierce_device_contact_list* solids,
                                                pierce_device_contact_list* sheets);

PIERCE_C_END

#endif
