/** Bodies, what they are in contact with, and which others they meet. */
#ifndef PIERCE_C_BODY_H
#define PIERCE_C_BODY_H

#include "pierce/c/base.h"

PIERCE_C_BEGIN

/** How a body moves. */
typedef enum pierce_motion {
    PIERCE_FIXED = 0,    /**< never; two fixed bodies are no pair */
    PIERCE_RIGID = 1,    /**< by its pose */
    PIERCE_DEFORMING = 2 /**< every vertex is given in world space */
} pierce_motion;

/** Adds a body that does not move. `pose`: seven numbers, the position x, y, z and the quaternion
 *  x, y, z, w of any length but zero; null: where its mesh is. Errors: a pose that is not finite,
 *  too far away or without a rotation. */
PIERCE_API pierce_status pierce_add_fixed_body(pierce_world* world, pierce_mesh_id mesh,
                                               const double* pose, pierce_body_id* body);
/** Adds a body that moves by its pose, which is as for pierce_add_fixed_body(). */
PIERCE_API pierce_status pierce_add_rigid_body(pierce_world* world, pierce_mesh_id mesh,
                                               const double* pose, pierce_body_id* body);
/** Adds a body whose vertices are given in world space: x, y, z of every vertex of the mesh, which
 *  are copied. Null with a count of 0: the mesh's own. Errors: a wrong count. */
PIERCE_API pierce_status pierce_add_deforming_body(pierce_world* world, pierce_mesh_id mesh,
                                                   const float* positions, size_t vertex_count,
                                                   pierce_body_id* body);
/** Removes a body. */
PIERCE_API pierce_status pierce_remove_body(pierce_world* world, pierce_body_id body);

/** Gives a body another mesh. Of a fixed or rigid body, `positions` are null with a count of 0; of
 *  a deforming one they are those of the mesh's vertices. Errors: a wrong count. */
PIERCE_API pierce_status pierce_set_mesh(pierce_world* world, pierce_body_id body,
                                         pierce_mesh_id mesh, const float* positions,
                                         size_t vertex_count);
PIERCE_API pierce_status pierce_mesh_of(const pierce_world* world, pierce_body_id body,
                                        pierce_mesh_id* mesh);
/** How a body moves: a pierce_motion. */
PIERCE_API pierce_status pierce_motion_of(const pierce_world* world, pierce_body_id body,
                                          uint32_t* motion);
/** The world position (x, y, z) of a vertex as the last call left it. Errors: a vertex out of
 *  range. */
PIERCE_API pierce_status pierce_vertex_position(const pierce_world* world, pierce_body_id body,
                                                uint32_t vertex, double* position);
/** The same of all vertices, in their order. `vertex_count`: of the body's mesh. Errors: another
 *  count. */
PIERCE_API pierce_status pierce_vertex_positions(const pierce_world* world, pierce_body_id body,
                                                 double* positions, size_t vertex_count);
/** Where a fixed or rigid body is: position x, y, z and quaternion x, y, z, w. Errors: a deforming
 *  body. */
PIERCE_API pierce_status pierce_pose_of(const pierce_world* world, pierce_body_id body,
                                        double* pose);

/** How contacts of a deforming body with itself are found (docs/cloth.md). */
typedef enum pierce_self_collision {
    PIERCE_SELF_OFF = 0,
    PIERCE_SELF_ON = 1,
    PIERCE_SELF_RAYS = 2,
    PIERCE_SELF_PUBLISHED = 3
} pierce_self_collision;

/** What a body is in contact with besides solids that it overlaps. */
typedef struct pierce_collision {
    size_t struct_size; /**< set by pierce_default_collision() */
    uint32_t self;      /**< a pierce_self_collision */
    uint32_t sheet;     /**< 0, 1: its surface keeps others out from both sides */
    double thickness;   /**< [length] of a sheet: what comes closer is in contact */
    double margin;      /**< [length] of a solid, also a rigid one; negative: the settings' */
} pierce_collision;

/** Fills a collision with its defaults. `struct_size`: sizeof *collision. */
PIERCE_API pierce_status pierce_default_collision(pierce_collision* collision, size_t struct_size);
/** Sets what a body is in contact with. Errors: a body that does not deform (but for its margin),
 *  a negative or not finite thickness, an open mesh that is to meet itself without being a sheet.
 */
PIERCE_API pierce_status pierce_set_collision(pierce_world* world, pierce_body_id body,
                                              const pierce_collision* collision);
/** What a body is in contact with; `collision->struct_size` must be set. */
PIERCE_API pierce_status pierce_collision_of(const pierce_world* world, pierce_body_id body,
                                             pierce_collision* collision);

/** The world of bodies that are in all worlds. */
#define PIERCE_ALL_WORLDS (-1)

/** Which other bodies a body meets (docs/filters.md). */
typedef struct pierce_filter {
    size_t struct_size; /**< set by pierce_default_filter() */
    uint32_t groups;    /**< one bit for each group that the body is in */
    uint32_t meets;     /**< one bit for each group whose bodies it meets */
    uint32_t chain;     /**< bodies of the same chain do not meet; 0: of none */
    int32_t world;      /**< bodies of different worlds do not meet; or PIERCE_ALL_WORLDS */
} pierce_filter;

/** Fills a filter with its defaults. `struct_size`: sizeof *filter. */
PIERCE_API pierce_status pierce_default_filter(pierce_filter* filter, size_t struct_size);
/** Sets which other bodies a body meets. Errors: a world below PIERCE_ALL_WORLDS, or too high. */
PIERCE_API pierce_status pierce_set_filter(pierce_world* world, pierce_body_id body,
                                           const pierce_filter* filter);
/** Which other bodies a body meets; `filter->struct_size` must be set. */
PIERCE_API pierce_status pierce_filter_of(const pierce_world* world, pierce_body_id body,
                                          pierce_filter* filter);
/** Leaves out the pair of two bodies, whatever their filters. Errors: a body and itself. */
PIERCE_API pierce_status pierce_exclude(pierce_world* world, pierce_body_id a, pierce_body_id b);
/** Takes the pair in again. */
PIERCE_API pierce_status pierce_include(pierce_world* world, pierce_body_id a, pierce_body_id b);

/** Two bodies. */
typedef struct pierce_body_pair {
    pierce_body_id a, b;
} pierce_body_pair;

/** The pairs that are left out so, each one's lower body first, sorted. */
PIERCE_API pierce_status pierce_excluded_pairs(pierce_world* world, const pierce_body_pair** pairs,
                                               size_t* count);

/** Tells whether two bodies meet: 0 if they do not. `a` is less than `b` by its lower 32 bits. It
 *  must not throw or jump, and must not call the world. */
typedef int (*pierce_pair_filter)(pierce_body_id a, pierce_body_id b, void* user);

/** Asks `filter` whether two bodies meet, where filters allow it and their boxes overlap, once a
 *  step for every such pair. Null: nothing is asked any more. `user` is handed to `filter`, which
 *  all threads of the backend call at the same time. It is neither saved nor asked by
 *  pierce_parting(). Errors: a backend that runs on a device. */
PIERCE_API pierce_status pierce_set_pair_filter(pierce_world* world, pierce_pair_filter filter,
                                                void* user);

PIERCE_C_END

#endif
