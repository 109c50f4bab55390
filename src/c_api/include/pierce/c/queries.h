/** Questions about bodies where they are. Lists are valid until the same call is made again. */
#ifndef PIERCE_C_QUERIES_H
#define PIERCE_C_QUERIES_H

#include "pierce/c/contact.h"

PIERCE_C_BEGIN

/** Why a vertex has a contact, or none (docs/explain.md). */
typedef enum pierce_reason {
    PIERCE_REASON_CONTACT = 0,
    PIERCE_REASON_EXCLUDED = 1,
    PIERCE_REASON_FILTERED = 2,
    PIERCE_REASON_BOTH_FIXED = 3,
    PIERCE_REASON_BOXES_APART = 4,
    PIERCE_REASON_OPEN_TARGET = 5,
    PIERCE_REASON_OUTSIDE_BOX = 6,
    PIERCE_REASON_OUTSIDE_SOLID = 7,
    PIERCE_REASON_NO_DIRECTION = 8,
    PIERCE_REASON_ENTRY_FIRST = 9,
    PIERCE_REASON_NOTHING_AHEAD = 10,
    PIERCE_REASON_NOT_INSIDE_OWN = 11,
    PIERCE_REASON_OWN_EXIT_FIRST = 12,
    PIERCE_REASON_BEYOND_RANGE = 13,
    PIERCE_REASON_NOT_LOOKED_AT = 14,
    PIERCE_REASON_NOT_LOOKED_FOR = 15,
    PIERCE_REASON_APART = 16,
    PIERCE_REASON_CLOSE_AT_REST = 17,
    PIERCE_REASON_BESIDE = 18,
    PIERCE_REASON_NO_TRIANGLE_NAMES_IT = 19,
    PIERCE_REASON_UNEXPLAINED = 20
} pierce_reason;

/** What a certificate proves to be outside. */
typedef enum pierce_certificate {
    PIERCE_CERTIFICATE_NONE = 0,
    PIERCE_CERTIFICATE_PATCH = 1,
    PIERCE_CERTIFICATE_PATCH_REST = 2,
    PIERCE_CERTIFICATE_VERTEX = 3
} pierce_certificate;

/** The answer to one question. Pointers are valid until the next pierce_explain(). */
typedef struct pierce_explanation {
    size_t struct_size;            /**< set by the caller: sizeof(pierce_explanation) */
    const char* text;              /**< one or two sentences for people */
    const pierce_contact* contact; /**< null if there is none */
    double distance;               /**< [length] from the other body, as far as it is known */
    double t;                      /**< [length] where the ray first crosses the other body */
    double own_exit;               /**< [length] where the ray leaves its own body */
    double certificate_left;       /**< [length] how far the bodies may still move */
    uint32_t certificate;          /**< a pierce_certificate */
    uint32_t reason;               /**< a pierce_reason */
    uint32_t triangle;             /**< of the other body, at `t`, or PIERCE_NO_TRIANGLE */
} pierce_explanation;

/** Says why `vertex` of `body` has a contact with `other` after the last step, or none;
 *  `explanation->struct_size` must be set. Errors: a vertex out of range; bodies were added,
 *  removed, moved or changed since. */
PIERCE_API pierce_status pierce_explain(pierce_world* world, pierce_body_id body,
                                        pierce_body_id other, uint32_t vertex,
                                        pierce_explanation* explanation);

/** How far body b has to move, and where to, until it does not overlap body a;
 *  `translation->struct_size` must be set. Errors: a body and itself, a sheet, places in device
 *  memory. */
PIERCE_API pierce_status pierce_parting(pierce_world* world, pierce_body_id a, pierce_body_id b,
                                        pierce_translation* translation);

/** Places where two bodies overlap along nearly the same direction. World space. */
typedef struct pierce_contact_patch {
    double area;         /**< [length^2] */
    double depth_volume; /**< [length^3] the integral of the depth over the area */
    double center[3];
    double normal[3]; /**< unit, from a to b */
    double depth;     /**< [length] of the deepest place that was looked at */
    double deepest[3];
} pierce_contact_patch;

/** What two solids have in common. World space. `patches`: valid until the next pierce_overlap().
 */
typedef struct pierce_common_volume {
    size_t struct_size;                  /**< set by the caller: sizeof(pierce_common_volume) */
    const pierce_contact_patch* patches; /**< the deepest first */
    size_t patch_count;
    double volume; /**< [length^3]; 0 if there is none */
    double center[3];
    double area_a;   /**< [length^2] of a's surface inside b */
    double area_b;   /**< [length^2] of b's surface inside a */
    double push[3];  /**< [length^2] the integral of the outward normal over a's surface inside b */
    double turn[3];  /**< [length^3] the same for turns about `center` */
    uint32_t exists; /**< 0: they have no volume in common, and the rest is 0 */
} pierce_common_volume;

/** What two solids have in common; `common->struct_size` must be set. `same_direction`: the least
 *  cosine between directions of one patch; 0.9 is a good one. Errors: a body and itself, a body
 *  without an inside. */
PIERCE_API pierce_status pierce_overlap(pierce_world* world, pierce_body_id a, pierce_body_id b,
                                        double same_direction, pierce_common_volume* common);

/** Where and when two solids first meet in the next step. World space. */
typedef struct pierce_impact {
    pierce_body_id a, b; /**< a < b by their lower 32 bits */
    double time;         /**< [0..1] of the step; never after they meet; of what touches when
                              the step begins: until it is as deep as the touch tolerance */
    double point[3];     /**< at that time */
    double normal[3];    /**< unit, from a to b */
    double gap;          /**< [length] along the normal as the step begins */
    uint32_t edges;      /**< 1: two edges meet; else a vertex and a face */
    uint32_t source;     /**< the body of the vertex: a (0) or b (1) */
    uint32_t vertex;     /**< of the source, or the first one of its edge */
    uint32_t edge_end;   /**< the second one of its edge, or PIERCE_NO_VERTEX */
    uint32_t triangle;   /**< of the other body */
    uint32_t padding;
    double start_a[3]; /**< where what meets is as the step begins, on a */
    double start_b[3]; /**< on b */
} pierce_impact;

/** The first meeting of every pair of solids that are apart when the next step begins and meet on
 *  their way to where they are now, sorted by (a, b). After it come first meetings of other
 *  vertices, up to `most_per_pair` in all. Errors: places in device memory. */
PIERCE_API pierce_status pierce_impacts(pierce_world* world, uint32_t most_per_pair,
                                        const pierce_impact** impacts, size_t* count);
/** The same for rigid bodies on their way from where they are now to `poses`, seven numbers each,
 *  while all others stay. Errors: a body that is not rigid or is named twice, a pose that is not
 *  usable, places in device memory. */
PIERCE_API pierce_status pierce_impacts_ahead(pierce_world* world, const pierce_body_id* bodies,
                                              size_t body_count, const double* poses,
                                              uint32_t most_per_pair, const pierce_impact** impacts,
                                              size_t* count);

/** Where a line of sight first meets a body. */
typedef struct pierce_ray_hit {
    pierce_body_id body; /**< 0: it meets none, and the rest is 0 */
    double t;            /**< [length] along the direction */
    double normal[3];    /**< of the triangle, unit, world space */
    uint32_t triangle;
    uint32_t padding;
} pierce_ray_hit;

/** The first body along each of `count` directions (x, y, z; any length) from one `origin`, with
 *  bodies where the last step saw them. `hits` has room for `count`. Errors: an origin or a
 *  direction that is not finite; bodies were added, removed, moved or changed since. */
PIERCE_API pierce_status pierce_cast_rays(pierce_world* world, const double* origin,
                                          const double* directions, size_t count,
                                          pierce_ray_hit* hits);

/** What is pressed against a point of a sensor, or near it. */
typedef struct pierce_probe_contact {
    pierce_body_id body; /**< 0: nothing, and the rest is 0 */
    double distance;     /**< [length] along the sensor's normal: negative where pressed in */
    double normal[3];    /**< of the triangle, unit, outward, world space */
    uint32_t triangle;
    uint32_t padding;
} pierce_probe_contact;

/** What touches each of `count` points (x, y, z) of a sensor, whose normals (x, y, z) point out of
 *  it, or is nearer than `radius`. `others`: the bodies that count; null with a count of 0: all.
 *  `contacts` has room for `count`. Errors: numbers that are not finite, a negative radius; bodies
 *  were added, removed, moved or changed since the last step. */
PIERCE_API pierce_status pierce_probe(pierce_world* world, const double* points,
                                      const double* normals, size_t count, double radius,
                                      const pierce_body_id* others, size_t other_count,
                                      pierce_probe_contact* contacts);

PIERCE_C_END

#endif
