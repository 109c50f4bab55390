/** Meshes of a world, and meshes that several worlds share. */
#ifndef PIERCE_C_MESH_H
#define PIERCE_C_MESH_H

#include "pierce/c/base.h"

PIERCE_C_BEGIN

/** What decides whether a point is inside a mesh (docs/meshes.md). */
typedef enum pierce_inside {
    PIERCE_INSIDE_AUTOMATIC = 0, /**< CLOSED where it is closed, WINDING where it nearly is */
    PIERCE_INSIDE_CLOSED = 1,    /**< the surface as given, if it is closed */
    PIERCE_INSIDE_WINDING = 2,   /**< the winding number of the surface with its holes closed */
    PIERCE_INSIDE_NONE = 3       /**< nothing: a surface without an inside */
} pierce_inside;

/** Is told what is being made, and the share of it that is made, from 0 to 1; by one thread at a
 *  time, which need not be the caller's. It must not throw or jump, nor use the mesh or a world
 *  that has it. */
typedef void (*pierce_progress)(const char* what, double share, void* user);

/** How a mesh is made. All zero but struct_size: the default. */
typedef struct pierce_mesh_options {
    size_t struct_size;
    uint32_t inside;          /**< a pierce_inside */
    uint32_t threads;         /**< 0: one per processor; the mesh is the same for every number */
    const char* cache;        /**< a trusted folder that keeps what is measured; null: none */
    pierce_progress progress; /**< null: none */
    void* user;               /**< handed to `progress` */
} pierce_mesh_options;

/** Fills options with their defaults. `struct_size`: sizeof *options. */
PIERCE_API pierce_status pierce_default_mesh_options(pierce_mesh_options* options,
                                                     size_t struct_size);

/** Adds a mesh. `name`: for messages, may be null. `positions`: x, y, z of every vertex.
 *  `triangles`: three vertices each, counter-clockwise seen from outside. All are copied.
 *  `options`: null for the defaults. Errors: an empty mesh, an index out of range, a position that
 *  is not finite or too far away, an unusable cache. */
PIERCE_API pierce_status pierce_add_mesh(pierce_world* world, const char* name,
                                         const float* positions, size_t vertex_count,
                                         const uint32_t* triangles, size_t triangle_count,
                                         const pierce_mesh_options* options, pierce_mesh_id* mesh);
/** The same for a mesh that is mostly `before`, cut, torn or grown: vertices keep their numbers,
 *  new ones follow. It is ready sooner, and steps with it take a little longer. */
PIERCE_API pierce_status pierce_add_changed_mesh(pierce_world* world, const char* name,
                                                 const float* positions, size_t vertex_count,
                                                 const uint32_t* triangles, size_t triangle_count,
                                                 pierce_mesh_id before,
                                                 const pierce_mesh_options* options,
                                                 pierce_mesh_id* mesh);

/** A mesh of no world, which any number of worlds may share. */
typedef struct pierce_shared_mesh pierce_shared_mesh;

/** Makes a mesh of no world. Arguments and errors are those of pierce_add_mesh(). */
PIERCE_API pierce_status pierce_create_shared_mesh(const char* name, const float* positions,
                                                   size_t vertex_count, const uint32_t* triangles,
                                                   size_t triangle_count,
                                                   const pierce_mesh_options* options,
                                                   pierce_shared_mesh** shared);
/** Lets a mesh go; worlds that have it keep it. Null: nothing happens. */
PIERCE_API void pierce_destroy_shared_mesh(pierce_shared_mesh* shared);
/** Adds a mesh that other worlds may have, too; it is neither copied nor measured again. */
PIERCE_API pierce_status pierce_add_shared_mesh(pierce_world* world,
                                                const pierce_shared_mesh* shared,
                                                pierce_mesh_id* mesh);

/** Takes a mesh of a world for other worlds. The caller lets it go with
 *  pierce_destroy_shared_mesh(); it stays when the world removes it or ends. */
PIERCE_API pierce_status pierce_share_mesh(const pierce_world* world, pierce_mesh_id mesh,
                                           pierce_shared_mesh** shared);

/** Removes a mesh. Errors: a body still uses it. */
PIERCE_API pierce_status pierce_remove_mesh(pierce_world* world, pierce_mesh_id mesh);

/** A mesh as steps see it. What pointers point to lives as long as the mesh. */
typedef struct pierce_mesh_info {
    size_t struct_size; /**< set by the caller: sizeof(pierce_mesh_info) */
    const char* name;
    const float* positions;    /**< vertex_count times x, y, z */
    const float* normals;      /**< vertex_count times x, y, z: unit and outward, or zero */
    const uint32_t* triangles; /**< triangle_count times three vertices: what contacts name */
    size_t vertex_count;
    size_t triangle_count; /**< differs from that of the given ones with WINDING */
    double volume;         /**< signed; negative: inside out */
    double mean_edge_length;
    double cap_share;              /**< area of the caps / area of the rest */
    uint32_t closed;               /**< 1: no border and one orientation, as given */
    uint32_t boundary_edges;       /**< as given, like the next three: edges with one triangle */
    uint32_t non_manifold_edges;   /**< with more than two */
    uint32_t inconsistent_edges;   /**< not run through equally often both ways */
    uint32_t degenerate_triangles; /**< without area; they are never hit */
    uint32_t inside;               /**< the pierce_inside in use, never AUTOMATIC */
    uint32_t covered_triangles;    /**< in other parts of the mesh, as a whole or partly */
    uint32_t joined_vertices;      /**< at the position of an earlier one */
    uint32_t turned_triangles;
    uint32_t left_out_triangles;
    uint32_t holes;         /**< that are closed */
    uint32_t cap_triangles; /**< that close them */
} pierce_mesh_info;

/** Describes a mesh; `info->struct_size` must be set. This is the counterpart of World::mesh(). */
PIERCE_API pierce_status pierce_mesh(const pierce_world* world, pierce_mesh_id mesh,
                                     pierce_mesh_info* info);
/** Writes 1 if the mesh is closed, in one piece and convex up to the rounding of its positions,
 * else 0: a rigid body with it can always leave another such body by its pierce_parting(). Takes n
 * log n for n triangles. */
PIERCE_API pierce_status pierce_is_convex(const pierce_world* world, pierce_mesh_id mesh,
                                          uint32_t* is_convex);
/** The place of one of a mesh's triangles among those that were given; PIERCE_NO_TRIANGLE if it
 *  closes a hole. Errors: a triangle out of range. */
PIERCE_API pierce_status pierce_given_triangle(const pierce_world* world, pierce_mesh_id mesh,
                                               uint32_t triangle, uint32_t* given);

PIERCE_C_END

#endif
