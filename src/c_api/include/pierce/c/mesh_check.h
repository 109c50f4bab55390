/** What is wrong with a mesh, and its repair. */
#ifndef PIERCE_C_MESH_CHECK_H
#define PIERCE_C_MESH_CHECK_H

#include "pierce/c/base.h"

PIERCE_C_BEGIN

/** What a mesh check looks for; docs/mesh_check.md says what to do about each. */
typedef enum pierce_mesh_defect {
    PIERCE_NO_TRIANGLES = 0,
    PIERCE_NOT_FINITE = 1,
    PIERCE_BAD_INDEX = 2,
    PIERCE_BORDER_EDGE = 3,
    PIERCE_FLIPPED_EDGE = 4,
    PIERCE_NON_MANIFOLD_EDGE = 5,
    PIERCE_INSIDE_OUT = 6,
    PIERCE_DEGENERATE_TRIANGLE = 7,
    PIERCE_DUPLICATE_TRIANGLE = 8,
    PIERCE_OPPOSITE_TRIANGLE = 9,
    PIERCE_BOWTIE_VERTEX = 10,
    PIERCE_NO_INWARD_DIRECTION = 11,
    PIERCE_SELF_INTERSECTION = 12,
    PIERCE_UNUSED_VERTEX = 13,
    PIERCE_DUPLICATE_VERTEX = 14,
    PIERCE_OUT_OF_RANGE = 15
} pierce_mesh_defect;

/** All defects of one kind. */
typedef struct pierce_mesh_finding {
    uint32_t defect;            /**< a pierce_mesh_defect */
    uint32_t changes_detection; /**< 0: contacts are the same with it as without it */
    uint32_t count;             /**< of all defects of the kind */
    uint32_t ids_per_place;     /**< 1, or 2 for edges and pairs of triangles */
    const uint32_t* places;     /**< of the first defects: ids of vertices or triangles as given */
    size_t place_count;         /**< times ids_per_place ids; 0 if there are no places */
    const char* name;           /**< in the plural, "border edges" */
    const char* meaning;        /**< for detection, in a sentence */
} pierce_mesh_finding;

/** What a check found. The library makes and frees it, so that it may grow at its end. */
typedef struct pierce_mesh_report {
    size_t struct_size; /**< set by the library: how much of this struct it knows */
    const pierce_mesh_finding* findings; /**< one per kind that was found */
    size_t finding_count;
    uint32_t vertices;
    uint32_t triangles;
    uint32_t components; /**< of triangles connected by vertices */
    uint32_t closed;     /**< 1: has triangles, no border and one orientation */
    uint32_t sound;      /**< 1: nothing was found that changes detection */
    uint32_t inside;     /**< the pierce_inside that a mesh of this data has; never AUTOMATIC */
    double volume;       /**< signed */
    double mean_edge_length;
    double box_lower[3]; /**< of all finite vertices; above box_upper if there are none */
    double box_upper[3];
    const char* inside_text; /**< what is done to give the mesh an inside, in a sentence */
} pierce_mesh_report;

/** How a mesh is checked. All zero but struct_size: the default. */
typedef struct pierce_mesh_check_options {
    size_t struct_size;
    uint32_t self_intersections; /**< 0, 1: look for them, too, which takes longer */
    uint32_t inside;             /**< a pierce_inside */
} pierce_mesh_check_options;

/** Fills options with their defaults. `struct_size`: sizeof *options. */
PIERCE_API pierce_status pierce_default_mesh_check_options(pierce_mesh_check_options* options,
                                                           size_t struct_size);

/** Looks for everything in a mesh that changes what detection finds; the data is as for
 *  pierce_add_mesh(), however bad. `options`: null for the defaults. The caller frees the report.
 */
PIERCE_API pierce_status pierce_check_mesh(const float* positions, size_t vertex_count,
                                           const uint32_t* triangles, size_t triangle_count,
                                           const pierce_mesh_check_options* options,
                                           const pierce_mesh_report** report);
/** Frees a report. Null: nothing happens. */
PIERCE_API void pierce_free_mesh_report(const pierce_mesh_report* report);

/** A mesh that was repaired. The library makes and frees it, so that it may grow at its end. */
typedef struct pierce_fixed_mesh {
    size_t struct_size;        /**< set by the library: how much of this struct it knows */
    const float* positions;    /**< vertex_count times x, y, z */
    const uint32_t* vertices;  /**< per vertex, its place in the given mesh */
    const uint32_t* triangles; /**< triangle_count times three vertices */
    size_t vertex_count;
    size_t triangle_count;
    const char* done; /**< in a sentence */
    uint32_t inside;  /**< a pierce_inside, never AUTOMATIC: NONE if there is no inside now */
} pierce_fixed_mesh;

/** Repairs a mesh: joins vertices, leaves out doubles, turns triangles, closes holes. Errors are
 *  those of pierce_add_mesh(). The caller frees the result. */
PIERCE_API pierce_status pierce_fix_mesh(const float* positions, size_t vertex_count,
                                         const uint32_t* triangles, size_t triangle_count,
                                         const pierce_fixed_mesh** fixed);
/** Frees a repaired mesh. Null: nothing happens. */
PIERCE_API void pierce_free_fixed_mesh(const pierce_fixed_mesh* fixed);

PIERCE_C_END

#endif
