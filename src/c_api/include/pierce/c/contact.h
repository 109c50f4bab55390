/** Contacts, and what lists of them tell. */
#ifndef PIERCE_C_CONTACT_H
#define PIERCE_C_CONTACT_H

#include "pierce/c/base.h"

PIERCE_C_BEGIN

/** How a contact was found. */
typedef enum pierce_found {
    PIERCE_FOUND_FULL = 0,
    PIERCE_FOUND_WALK = 1,
    PIERCE_FOUND_PREDICTION = 2,
    PIERCE_FOUND_SELF = 3,
    PIERCE_FOUND_NEAR = 4,
    PIERCE_FOUND_CROSSING = 5,
    PIERCE_FOUND_REMEMBERED = 6,
    PIERCE_FOUND_TANGLED = 7,
    PIERCE_FOUND_SEPARATION = 8
} pierce_found;

/** A point of one body inside another, and the point where it leaves that other body; or two
 *  features of sheets that meet. World space. pierce/contact.hpp says more of each field. The
 *  layout is fixed: fields are added at the end alone, and a list's stride says how large records
 *  are. */
typedef struct pierce_contact {
    pierce_body_id a, b; /**< a <= b by their lower 32 bits; equal: a body and itself */
    uint8_t source;      /**< the vertex belongs to a (0) or b (1); the other one is the target */
    uint8_t grazing;     /**< 1: the ray meets the triangle so flatly that the depth is uncertain */
    uint8_t found;       /**< a pierce_found */
    uint8_t reprojected; /**< 1: ends at the closest point of the target */
    uint8_t of_sheet;    /**< 1: between surfaces that keep their thickness */
    uint8_t unknown_side; /**< 1: of a sheet whose way out is unknown */
    uint16_t padding_a;
    uint32_t vertex;     /**< of the source; if an edge is in contact, its first vertex */
    uint32_t edge_end;   /**< second vertex of the source's edge, or PIERCE_NO_VERTEX */
    uint32_t edge;       /**< of the source's mesh, if an edge is in contact */
    uint32_t chord;      /**< which of the edge's parts inside the target */
    uint32_t other_edge; /**< of the target's mesh, if two edges are near or those of sheets */
    uint32_t triangle;   /**< of the target */
    uint32_t age;        /**< steps in a row it has been in contact; 0: new */
    uint32_t padding_b;
    double along;          /**< where on the edge: 0 at its first vertex, 1 at its second */
    double time;           /**< [0..1] when in the step the two of a sheet's contact meet; else 1 */
    double distance;       /**< signed: negative where bodies overlap, positive where only near */
    double barycentric[3]; /**< of the target point in the triangle */
    double point_a[3];     /**< on body a */
    double point_b[3];     /**< on body b */
    double normal[3];      /**< unit, from a to b */
    double face_normal[3]; /**< unit, outward, of the target triangle */
    double padding_c;
} pierce_contact;

/** A list of contacts. The next record is `stride` bytes further; those of the library are aligned
 *  to 16 bytes. */
typedef struct pierce_contact_list {
    const pierce_contact* contacts;
    size_t count;
    size_t stride; /**< [byte] at least sizeof(pierce_contact) */
} pierce_contact_list;

/** The contact at a place of a list, which is not checked. */
static inline const pierce_contact* pierce_contact_at(const pierce_contact_list* list,
                                                      size_t place) {
    const void* record = (const char*)list->contacts + place * list->stride;
    return (const pierce_contact*)record;
}

/** The last step's contacts, sorted by (a, b, source, vertex); those of sheets follow. They are not
 *  copied: valid until the next pierce_detect(), or until the world is destroyed. */
PIERCE_API pierce_status pierce_contacts(const pierce_world* world, pierce_contact_list* list);

/** Contacts that outlast their step, and the world. */
typedef struct pierce_kept_contacts pierce_kept_contacts;

/** Keeps the last step's contacts: `list` is valid until pierce_release_contacts(), whatever
 *  becomes of the world. Nothing is copied unless there are contacts of sheets, or steps run on a
 *  device. */
PIERCE_API pierce_status pierce_keep_contacts(pierce_world* world, pierce_kept_contacts** kept,
                                              pierce_contact_list* list);
/** Lets kept contacts go. Null: nothing happens. */
PIERCE_API void pierce_release_contacts(pierce_kept_contacts* kept);

/** A number that names a contact within its pair, in every step. */
PIERCE_API pierce_status pierce_contact_feature(const pierce_contact* contact, uint64_t* feature);
/** A hash of all fields but `age` and `found`: equal lists have equal hashes, on all backends. */
PIERCE_API pierce_status pierce_contact_hash(const pierce_contact_list* list, uint64_t* hash);

/** Which contacts are new, which were there before, and which are gone. `began` and `stayed`:
 *  places in `later`, with room for later->count; `ended`: places in `earlier`, with room for
 *  earlier->count. Each may be null, and its count with it. */
PIERCE_API pierce_status pierce_contact_changes(const pierce_contact_list* earlier,
                                                const pierce_contact_list* later, uint32_t* began,
                                                size_t* began_count, uint32_t* stayed,
                                                size_t* stayed_count, uint32_t* ended,
                                                size_t* ended_count);

/** A contact that stands for others of its pair. */
typedef struct pierce_reduced_contact {
    uint32_t contact; /**< its place in the list */
    uint32_t padding;
    double weight; /**< how many times its force counts; positive */
} pierce_reduced_contact;

/** Picks few contacts of each pair, with weights, that have the resultant force and torque of all.
 *  `reduced` has room for list->count. Errors: `most_per_pair` below 6. */
PIERCE_API pierce_status pierce_reduce(const pierce_contact_list* list, uint32_t most_per_pair,
                                       pierce_reduced_contact* reduced, size_t* reduced_count);

/** A way to take two bodies apart by moving one of them. */
typedef struct pierce_translation {
    size_t struct_size;  /**< set by the caller: sizeof(pierce_translation) */
    double direction[3]; /**< unit, world space: where body b goes; 0 if there is none */
    double depth;        /**< [length] how far */
    uint32_t exists;     /**< 0: there is none */
} pierce_translation;

/** The shortest translation of body b that all contacts of one pair ask for, if there is one;
 *  `translation->struct_size` must be set. */
PIERCE_API pierce_status pierce_least_translation(const pierce_contact_list* list,
                                                  pierce_translation* translation);

PIERCE_C_END

#endif
