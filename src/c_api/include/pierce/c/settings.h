/** How worlds detect contacts, and where steps run. */
#ifndef PIERCE_C_SETTINGS_H
#define PIERCE_C_SETTINGS_H

#include "pierce/c/base.h"

PIERCE_C_BEGIN

/** Which parts of a body are looked for inside other bodies. */
typedef enum pierce_coverage {
    PIERCE_COVERAGE_VERTICES = 0, /**< its vertices */
    PIERCE_COVERAGE_COMPLETE = 1, /**< all its edges, too */
    PIERCE_COVERAGE_OVERLAPS = 2  /**< edges only of pairs in which no vertex has a depth */
} pierce_coverage;

/** How the last step's results are used. */
typedef enum pierce_temporal {
    PIERCE_TEMPORAL_OFF = 0,
    PIERCE_TEMPORAL_PAPER = 1,
    PIERCE_TEMPORAL_CERTIFIED = 2 /**< the contacts of OFF, without rays proved to be needless */
} pierce_temporal;

/** How a world detects contacts; pierce/settings.hpp says more of each field. */
typedef struct pierce_settings {
    size_t struct_size;         /**< set by pierce_default_settings() */
    double open_body_range;     /**< [mean edge length] reach of rays of bodies without an inside;
                                   how deep sheets remember what has been through */
    double margin;              /**< [length] solids nearer than this are in contact, too */
    double prediction_distance; /**< [length] PAPER: how far predictions look; negative: automatic
                                 */
    double walk_threshold;      /**< [mean edge length] PAPER: walks while bodies moved less */
    uint32_t coverage;          /**< a pierce_coverage */
    uint32_t temporal;          /**< a pierce_temporal */
    uint32_t full_every;        /**< PAPER: all vertices are looked at every so many steps */
    uint32_t reproject;         /**< 0, 1: contacts end at the closest point of the surface */
    uint32_t may_rest;          /**< 0, 1: CERTIFIED forgets for a while where that is cheaper */
    uint32_t predict;           /**< 0, 1: PAPER looks ahead for vertices about to enter */
} pierce_settings;

/** Fills settings with their defaults, which suit any scale. `struct_size`: sizeof *settings. */
PIERCE_API pierce_status pierce_default_settings(pierce_settings* settings, size_t struct_size);

/** Where steps run. The contacts are the same on all. */
typedef enum pierce_backend_kind {
    PIERCE_BACKEND_DEFAULT = 0,   /**< Embree if it is built in, else BVH */
    PIERCE_BACKEND_REFERENCE = 1, /**< brute force on one thread: slow, and right by definition */
    PIERCE_BACKEND_BVH = 2,       /**< our own trees on one thread */
    PIERCE_BACKEND_EMBREE = 3,    /**< Embree's trees, oneTBB's threads */
    PIERCE_BACKEND_CUDA = 4       /**< a GPU */
} pierce_backend_kind;

/** How trees of our own are built. */
typedef enum pierce_tree_builder {
    PIERCE_TREES_DEFAULT = 0, /**< LBVH on the host, TRBVH on a GPU */
    PIERCE_TREES_LBVH = 1,
    PIERCE_TREES_HLBVH = 2,
    PIERCE_TREES_TRBVH = 3,
    PIERCE_TREES_PLOC = 4
} pierce_tree_builder;

/** Where a world's steps run, and how. All zero but struct_size: the default. */
typedef struct pierce_backend_options {
    size_t struct_size;
    uint32_t kind;           /**< a pierce_backend_kind */
    int32_t threads;         /**< of Embree's backend, at most; 0: all of the machine */
    uint32_t tree_builder;   /**< a pierce_tree_builder, for BVH and CUDA */
    uint32_t rebuild;        /**< 0, 1: BVH and CUDA build all trees anew in every step */
    uint32_t stage_by_stage; /**< 0, 1: CUDA times every stage, and captures no graph */
    uint32_t parts;    /**< so many backends share the world: of CUDA one per device, of Embree
                            with a part of the threads; 0: one */
    double host_share; /**< of the work of one device, which processors do beside CUDA; 0: none */
} pierce_backend_options;

/** Fills options with their defaults. `struct_size`: sizeof *options. */
PIERCE_API pierce_status pierce_default_backend_options(pierce_backend_options* options,
                                                        size_t struct_size);

/** PIERCE_OK if a backend (pierce_backend_kind) can be used here, PIERCE_NOT_BUILT if this library
 *  was built without it, PIERCE_INVALID_INPUT if this machine cannot run it; the message says why.
 */
PIERCE_API pierce_status pierce_check_backend(uint32_t kind);

PIERCE_C_END

#endif
