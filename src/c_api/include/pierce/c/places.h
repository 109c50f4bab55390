/** Where bodies are. A place that is not finite or too far away is no error: the body is left out
 *  of steps, and counted in their stats, until a usable one is set. Everything is copied. */
#ifndef PIERCE_C_PLACES_H
#define PIERCE_C_PLACES_H

#include "pierce/c/base.h"

PIERCE_C_BEGIN

/** Moves a fixed or rigid body. `pose`: the position x, y, z and the quaternion x, y, z, w. Errors:
 *  a deforming body. */
PIERCE_API pierce_status pierce_set_pose(pierce_world* world, pierce_body_id body,
                                         const double* pose);
/** Moves many: `poses` has seven numbers for each of `body_count` bodies. */
PIERCE_API pierce_status pierce_set_poses(pierce_world* world, const pierce_body_id* bodies,
                                          size_t body_count, const double* poses);
PIERCE_API pierce_status pierce_set_poses_float(pierce_world* world, const pierce_body_id* bodies,
                                                size_t body_count, const float* poses);

/** Moves the vertices of a deforming body: x, y, z of each, in world space. Errors: a wrong count,
 *  a body that does not deform. */
PIERCE_API pierce_status pierce_set_positions(pierce_world* world, pierce_body_id body,
                                              const float* positions, size_t vertex_count);
/** Moves those of many; their positions follow each other. `vertex_count`: of all together. */
PIERCE_API pierce_status pierce_set_positions_many(pierce_world* world,
                                                   const pierce_body_id* bodies, size_t body_count,
                                                   const float* positions, size_t vertex_count);

/** Moves the vertices of a deforming body, and sets where they were when the step began, in place
 *  of where the last step left them. */
PIERCE_API pierce_status pierce_set_motion(pierce_world* world, pierce_body_id body,
                                           const float* start, const float* positions,
                                           size_t vertex_count);
/** The same for a fixed or rigid body, with two poses. */
PIERCE_API pierce_status pierce_set_motion_poses(pierce_world* world, pierce_body_id body,
                                                 const double* start, const double* pose);
/** Makes the next step assume that no sheet is through anything when it begins. */
PIERCE_API pierce_status pierce_forget_sides(pierce_world* world);

PIERCE_C_END

#endif
