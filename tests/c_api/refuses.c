/* Every call of the C API, where it refuses. Prints nothing if all is well. */
#include "scene.h"

/* More than anybody has, and less than would overflow. */
static const size_t too_many = (size_t)1 << 40;

static int write_nothing(const void* bytes, size_t size, void* user) {
    (void)bytes, (void)size, (void)user;
    return 1;
}

static int meet_all(pierce_body_id a, pierce_body_id b, void* user) {
    (void)a, (void)b, (void)user;
    return 1;
}

/* A struct of a later version: what is new there is zero, or not. */
typedef struct later_settings {
    pierce_settings now;
    uint64_t later;
} later_settings;

static void structs(void) {
    pierce_world* world = NULL;
    pierce_settings settings;
    later_settings later;
    pierce_backend_options backend;
    pierce_mesh_options mesh;
    pierce_mesh_check_options check;
    pierce_collision collision;
    pierce_filter filter;
    const size_t size = sizeof settings;
    REFUSES(pierce_default_settings(NULL, size), "settings is null");
    REFUSES(pierce_default_settings(&settings, 0), "struct_size");
    REFUSES(pierce_default_settings(&settings, size - 8), "struct_size");
    REFUSES(pierce_default_backend_options(NULL, sizeof backend), "options is null");
    REFUSES(pierce_default_backend_options(&backend, 1), "struct_size");
    REFUSES(pierce_default_mesh_options(NULL, sizeof mesh), "options is null");
    REFUSES(pierce_default_mesh_options(&mesh, 1), "struct_size");
    REFUSES(pierce_default_mesh_check_options(NULL, sizeof check), "options is null");
    REFUSES(pierce_default_mesh_check_options(&check, 1), "struct_size");
    REFUSES(pierce_default_collision(NULL, sizeof collision), "collision is null");
    REFUSES(pierce_default_collision(&collision, 1), "struct_size");
    REFUSES(pierce_default_filter(NULL, sizeof filter), "filter is null");
    REFUSES(pierce_default_filter(&filter, 1), "struct_size");

    memset(&later, 0xff, sizeof later);
    WORKS(pierce_default_settings(&later.now, sizeof later));
    CHECK(later.now.struct_size == sizeof later && later.later == 0);
    WORKS(pierce_create_world(&later.now, NULL, &world));
    pierce_destroy_world(world);
    world = NULL;
    later.later = 1;
    REFUSES(pierce_create_world(&later.now, NULL, &world), "does not know");
    later.now.struct_size = (size_t)-1;
    REFUSES(pierce_create_world(&later.now, NULL, &world), "struct_size");
    later.now.struct_size = 0;
    REFUSES(pierce_create_world(&later.now, NULL, &world), "struct_size");
    CHECK(world == NULL);
}

static void worlds(void) {
    pierce_world* world = NULL;
    pierce_settings settings;
    pierce_backend_options backend;
    const char* text = NULL;
    WORKS(pierce_default_settings(&settings, sizeof settings));
    WORKS(pierce_default_backend_options(&backend, sizeof backend));
    REFUSES(pierce_create_world(NULL, NULL, NULL), "world is null");
    settings.coverage = 3;
    REFUSES(pierce_create_world(&settings, NULL, &world), "settings.coverage is 3");
    settings.coverage = 0;
    settings.temporal = 77;
    REFUSES(pierce_create_world(&settings, NULL, &world), "settings.temporal");
    settings.temporal = 0;
    settings.margin = (double)NAN;
    REFUSES(pierce_create_world(&settings, NULL, &world), "margin");
    backend.kind = 9;
    REFUSES(pierce_create_world(NULL, &backend, &world), "backend.kind");
    backend.kind = PIERCE_BACKEND_EMBREE;
    backend.threads = -1;
    REFUSES(pierce_create_world(NULL, &backend, &world), "thread");
    backend.tree_builder = 5;
    REFUSES(pierce_create_world(NULL, &backend, &world), "backend.tree_builder");
    backend.tree_builder = 0;
    backend.host_share = 0.1;
    REFUSES(pierce_create_world(NULL, &backend, &world), "backend.host_share");
    backend.host_share = 0;
    backend.parts = 2;
    REFUSES(pierce_create_world(NULL, &backend, &world), "thread");
    backend.struct_size = 3;
    REFUSES(pierce_create_world(NULL, &backend, &world), "struct_size");
    REFUSES(pierce_check_backend(5), "kind");
    WORKS(pierce_check_backend(PIERCE_BACKEND_REFERENCE));
    CHECK(world == NULL);
    pierce_destroy_world(NULL);

    WORKS(pierce_create_world(NULL, NULL, &world));
    REFUSES(pierce_backend(NULL, &text), "world is null");
    REFUSES(pierce_backend(world, NULL), "description is null");
    REFUSES(pierce_save(NULL, write_nothing, NULL), "world is null");
    REFUSES(pierce_save(world, NULL, NULL), "write is null");
    REFUSES(pierce_save(world, write_nothing, NULL), "written");
    pierce_destroy_world(world);
    world = NULL;
    REFUSES(pierce_restore(NULL, 0, NULL, &world), "bytes is null");
    REFUSES(pierce_restore("no world", 8, NULL, &world), "");
    REFUSES(pierce_restore("no world", 8, NULL, NULL), "world is null");
    REFUSES(pierce_restore("no world", 8, &backend, &world), "struct_size");
    CHECK(world == NULL);
}

/* What was not built in says so with a status of its own. */
static void missing_backend(void) {
    pierce_world* world = NULL;
    pierce_backend_options backend;
    const pierce_status cuda = pierce_check_backend(PIERCE_BACKEND_CUDA);
    WORKS(pierce_default_backend_options(&backend, sizeof backend));
    backend.kind = PIERCE_BACKEND_CUDA;
    CHECK(cuda == PIERCE_OK || strstr(pierce_last_error(), "CUDA") != NULL);
    CHECK(pierce_create_world(NULL, &backend, &world) == cuda);
    if (cuda == PIERCE_OK) {
        REFUSES(pierce_set_pair_filter(world, meet_all, NULL), "pair filter");
        WORKS(pierce_set_pair_filter(world, NULL, NULL));
    }
    pierce_destroy_world(world);
}

static void meshes(scene* s) {
    pierce_world* w = s->world;
    torus* t = &s->shape;
    pierce_mesh_id mesh = 0;
    pierce_mesh_options options;
    pierce_mesh_info info = {.struct_size = sizeof info};
    pierce_shared_mesh* shared = NULL;
    pierce_mesh_check_options check;
    const pierce_mesh_report* report = NULL;
    const pierce_fixed_mesh* fixed = NULL;
    const float bad[9] = {0, 0, 0, 1, 0, (float)NAN, 0, 1, 0};
    const uint32_t corners[3] = {0, 1, 2};
    uint32_t given = 0;
    const size_t nv = torus_vertices, nt = torus_triangles;
    const float* p = t->positions;
    const uint32_t* i = t->triangles;
    REFUSES(pierce_add_mesh(NULL, "t", p, nv, i, nt, NULL, &mesh), "world is null");
    REFUSES(pierce_add_mesh(w, "t", NULL, nv, i, nt, NULL, &mesh), "positions is null");
    REFUSES(pierce_add_mesh(w, "t", p, nv, NULL, nt, NULL, &mesh), "triangles is null");
    REFUSES(pierce_add_mesh(w, "t", p, nv, i, nt, NULL, NULL), "mesh is null");
    REFUSES(pierce_add_mesh(w, "t", p, too_many, i, nt, NULL, &mesh), "positions has too many");
    REFUSES(pierce_add_mesh(w, "t", p, nv, i, too_many, NULL, &mesh), "triangles has too many");
    REFUSES(pierce_add_mesh(w, "t", NULL, 0, NULL, 0, NULL, &mesh), "");
    REFUSES(pierce_add_mesh(w, "t", p, nv - 1, i, nt, NULL, &mesh), "'t'");
    REFUSES(pierce_add_mesh(w, "bad", bad, 3, corners, 1, NULL, &mesh), "'bad'");
    WORKS(pierce_default_mesh_options(&options, sizeof options));
    options.inside = 4;
    REFUSES(pierce_add_mesh(w, "t", p, nv, i, nt, &options, &mesh), "options.inside");
    options.inside = 0;
    options.cache = "/dev/null/folder";
    REFUSES(pierce_add_mesh(w, "t", p, nv, i, nt, &options, &mesh), "/dev/null/folder");
    options.struct_size -= 1;
    REFUSES(pierce_add_mesh(w, "t", p, nv, i, nt, &options, &mesh), "struct_size");
    REFUSES(pierce_add_changed_mesh(NULL, "t", p, nv, i, nt, s->mesh, NULL, &mesh), "world is");
    REFUSES(pierce_add_changed_mesh(w, "t", p, nv, i, nt, 0, NULL, &mesh), "mesh handle is null");
    REFUSES(pierce_add_changed_mesh(w, "t", p, nv, i, nt, 99, NULL, &mesh), "mesh");
    REFUSES(pierce_add_changed_mesh(w, "t", p, nv, i, nt, s->mesh, NULL, NULL), "mesh is null");
    REFUSES(pierce_create_shared_mesh("t", p, nv - 1, i, nt, NULL, &shared), "'t'");
    REFUSES(pierce_create_shared_mesh("t", p, nv, i, nt, NULL, NULL), "shared is null");
    REFUSES(pierce_add_shared_mesh(w, NULL, &mesh), "shared is null");
    CHECK(mesh == 0 && shared == NULL);
    pierce_destroy_shared_mesh(NULL);
    WORKS(pierce_create_shared_mesh("t", p, nv, i, nt, NULL, &shared));
    REFUSES(pierce_add_shared_mesh(NULL, shared, &mesh), "world is null");
    REFUSES(pierce_add_shared_mesh(w, shared, NULL), "mesh is null");
    WORKS(pierce_add_shared_mesh(w, shared, &mesh));
    pierce_destroy_shared_mesh(shared);
    REFUSES(pierce_share_mesh(NULL, mesh, &shared), "world is null");
    REFUSES(pierce_share_mesh(w, mesh, NULL), "shared is null");
    REFUSES(pierce_share_mesh(w, mesh + 9, &shared), "mesh");

    REFUSES(pierce_remove_mesh(NULL, mesh), "world is null");
    REFUSES(pierce_remove_mesh(w, s->mesh), "still used");
    WORKS(pierce_remove_mesh(w, mesh));
    REFUSES(pierce_remove_mesh(w, mesh), "was removed");
    REFUSES(pierce_remove_mesh(w, 0), "mesh handle is null");
    REFUSES(pierce_remove_mesh(w, UINT64_MAX), "mesh");
    REFUSES(pierce_mesh(w, mesh, &info), "was removed");
    REFUSES(pierce_mesh(w, s->mesh, NULL), "info is null");
    REFUSES(pierce_mesh(NULL, s->mesh, &info), "world is null");
    info.struct_size = 16;
    REFUSES(pierce_mesh(w, s->mesh, &info), "struct_size");
    REFUSES(pierce_given_triangle(NULL, s->mesh, 0, &given), "world is null");
    REFUSES(pierce_given_triangle(w, mesh, 0, &given), "was removed");
    REFUSES(pierce_given_triangle(w, s->mesh, torus_triangles, &given), "has no triangle");
    REFUSES(pierce_given_triangle(w, s->mesh, 0, NULL), "given is null");
    REFUSES(pierce_is_convex(NULL, s->mesh, &given), "world is null");
    REFUSES(pierce_is_convex(w, mesh, &given), "was removed");
    REFUSES(pierce_is_convex(w, s->mesh, NULL), "is_convex is null");

    WORKS(pierce_default_mesh_check_options(&check, sizeof check));
    REFUSES(pierce_check_mesh(NULL, nv, i, nt, NULL, &report), "positions is null");
    REFUSES(pierce_check_mesh(p, nv, NULL, nt, NULL, &report), "triangles is null");
    REFUSES(pierce_check_mesh(p, nv, i, nt, NULL, NULL), "report is null");
    check.inside = 4;
    REFUSES(pierce_check_mesh(p, nv, i, nt, &check, &report), "options.inside");
    check.struct_size = 8;
    REFUSES(pierce_check_mesh(p, nv, i, nt, &check, &report), "struct_size");
    WORKS(pierce_check_mesh(bad, 3, corners, 1, NULL, &report));
    CHECK(report->findings[0].defect == PIERCE_NOT_FINITE && report->sound == 0);
    pierce_free_mesh_report(report);
    pierce_free_mesh_report(NULL);
    REFUSES(pierce_fix_mesh(bad, 3, corners, 1, &fixed), "");
    REFUSES(pierce_fix_mesh(NULL, 3, corners, 1, &fixed), "positions is null");
    REFUSES(pierce_fix_mesh(p, nv, i, nt, NULL), "fixed is null");
    CHECK(fixed == NULL);
    pierce_free_fixed_mesh(NULL);
}

static void bodies(scene* s, pierce_body_id stale) {
    pierce_world* w = s->world;
    pierce_body_id body = 0;
    pierce_mesh_id mesh = 0;
    pierce_collision collision;
    pierce_filter filter;
    pierce_body_id soft = 0;
    double at[3], pose[7], bad[7] = {0, 0, 0, 0, 0, 0, 1};
    uint32_t motion = 0;
    const pierce_body_pair* pairs = NULL;
    size_t pair_count = 0;
    const float* p = s->shape.positions;
    bad[1] = (double)INFINITY;
    REFUSES(pierce_add_fixed_body(NULL, s->mesh, NULL, &body), "world is null");
    REFUSES(pierce_add_fixed_body(w, 0, NULL, &body), "mesh handle is null");
    REFUSES(pierce_add_fixed_body(w, s->mesh, bad, &body), "not finite");
    REFUSES(pierce_add_fixed_body(w, s->mesh, NULL, NULL), "body is null");
    REFUSES(pierce_add_rigid_body(NULL, s->mesh, NULL, &body), "world is null");
    REFUSES(pierce_add_rigid_body(w, 7, NULL, &body), "mesh");
    REFUSES(pierce_add_rigid_body(w, s->mesh, bad, &body), "not finite");
    REFUSES(pierce_add_rigid_body(w, s->mesh, NULL, NULL), "body is null");
    REFUSES(pierce_add_deforming_body(NULL, s->mesh, NULL, 0, &body), "world is null");
    REFUSES(pierce_add_deforming_body(w, s->mesh, NULL, 4, &body), "positions is null");
    REFUSES(pierce_add_deforming_body(w, s->mesh, p, 4, &body), "positions, got 4");
    REFUSES(pierce_add_deforming_body(w, s->mesh, p, too_many, &body), "too many");
    REFUSES(pierce_add_deforming_body(w, s->mesh, NULL, 0, NULL), "body is null");
    REFUSES(pierce_remove_body(NULL, s->above), "world is null");
    REFUSES(pierce_remove_body(w, stale), "was removed");
    REFUSES(pierce_remove_body(w, 0), "body handle is null");
    REFUSES(pierce_set_mesh(NULL, s->above, s->mesh, NULL, 0), "world is null");
    REFUSES(pierce_set_mesh(w, stale, s->mesh, NULL, 0), "was removed");
    REFUSES(pierce_set_mesh(w, s->above, 0, NULL, 0), "mesh handle is null");
    REFUSES(pierce_set_mesh(w, s->above, s->mesh, p, torus_vertices), "");
    REFUSES(pierce_set_mesh(w, s->above, s->mesh, NULL, 3), "positions is null");
    REFUSES(pierce_mesh_of(NULL, s->above, &mesh), "world is null");
    REFUSES(pierce_mesh_of(w, stale, &mesh), "was removed");
    REFUSES(pierce_mesh_of(w, s->above, NULL), "mesh is null");
    REFUSES(pierce_motion_of(NULL, s->above, &motion), "world is null");
    REFUSES(pierce_motion_of(w, stale, &motion), "was removed");
    REFUSES(pierce_motion_of(w, s->above, NULL), "motion is null");
    REFUSES(pierce_vertex_position(NULL, s->above, 0, at), "world is null");
    REFUSES(pierce_vertex_position(w, stale, 0, at), "was removed");
    REFUSES(pierce_vertex_position(w, s->above, torus_vertices, at), "no vertex");
    REFUSES(pierce_vertex_position(w, s->above, 0, NULL), "position is null");
    REFUSES(pierce_vertex_positions(NULL, s->above, at, 1), "world is null");
    REFUSES(pierce_vertex_positions(w, stale, at, 1), "was removed");
    REFUSES(pierce_vertex_positions(w, s->above, at, 1), "vertices, and there is room for 1");
    REFUSES(pierce_vertex_positions(w, s->above, NULL, torus_vertices), "positions is null");
    REFUSES(pierce_pose_of(NULL, s->above, pose), "world is null");
    REFUSES(pierce_pose_of(w, stale, pose), "was removed");
    WORKS(pierce_add_deforming_body(w, s->mesh, NULL, 0, &soft));
    REFUSES(pierce_pose_of(w, soft, pose), "deforms");
    WORKS(pierce_remove_body(w, soft));
    REFUSES(pierce_pose_of(w, s->above, NULL), "pose is null");

    WORKS(pierce_default_collision(&collision, sizeof collision));
    REFUSES(pierce_set_collision(NULL, s->above, &collision), "world is null");
    REFUSES(pierce_set_collision(w, stale, &collision), "was removed");
    REFUSES(pierce_set_collision(w, s->above, NULL), "collision is null");
    REFUSES(pierce_collision_of(NULL, s->above, &collision), "world is null");
    REFUSES(pierce_collision_of(w, stale, &collision), "was removed");
    REFUSES(pierce_collision_of(w, s->above, NULL), "collision is null");
    collision.margin = (double)NAN;
    REFUSES(pierce_set_collision(w, s->above, &collision), "margin");
    collision.self = 4;
    REFUSES(pierce_set_collision(w, s->above, &collision), "collision.self");
    collision.struct_size = 0;
    REFUSES(pierce_set_collision(w, s->above, &collision), "struct_size");
    REFUSES(pierce_collision_of(w, s->above, &collision), "struct_size");

    WORKS(pierce_default_filter(&filter, sizeof filter));
    REFUSES(pierce_set_filter(NULL, s->above, &filter), "world is null");
    REFUSES(pierce_set_filter(w, stale, &filter), "was removed");
    REFUSES(pierce_set_filter(w, s->above, NULL), "filter is null");
    REFUSES(pierce_filter_of(NULL, s->above, &filter), "world is null");
    REFUSES(pierce_filter_of(w, stale, &filter), "was removed");
    REFUSES(pierce_filter_of(w, s->above, NULL), "filter is null");
    filter.world = -2;
    REFUSES(pierce_set_filter(w, s->above, &filter), "world");
    filter.struct_size = 0;
    REFUSES(pierce_set_filter(w, s->above, &filter), "struct_size");
    REFUSES(pierce_filter_of(w, s->above, &filter), "struct_size");
    REFUSES(pierce_exclude(NULL, s->above, s->below), "world is null");
    REFUSES(pierce_exclude(w, s->above, s->above), "");
    REFUSES(pierce_exclude(w, s->above, stale), "was removed");
    REFUSES(pierce_include(NULL, s->above, s->below), "world is null");
    REFUSES(pierce_include(w, stale, s->above), "was removed");
    REFUSES(pierce_include(w, s->above, s->above), "are no pair");
    REFUSES(pierce_excluded_pairs(NULL, &pairs, &pair_count), "world is null");
    REFUSES(pierce_excluded_pairs(w, NULL, &pair_count), "pairs is null");
    REFUSES(pierce_excluded_pairs(w, &pairs, NULL), "count is null");
    REFUSES(pierce_set_poses(w, NULL, 0xffffffffu, bad), "bodies is null");
    REFUSES(pierce_set_pair_filter(NULL, meet_all, NULL), "world is null");
    REFUSES(pierce_set_pair_filter(NULL, NULL, NULL), "world is null");
}

static void worlds_within(scene* s) {
    pierce_world* w = s->world;
    const int32_t* numbers = NULL;
    const pierce_body_id* of = NULL;
    pierce_offsets offsets = {.struct_size = sizeof offsets};
    size_t count = 0;
    int32_t first = 0;
    REFUSES(pierce_worlds(NULL, &numbers, &count), "world is null");
    REFUSES(pierce_worlds(w, NULL, &count), "worlds is null");
    REFUSES(pierce_worlds(w, &numbers, NULL), "count is null");
    REFUSES(pierce_bodies_of(NULL, 0, &of, &count), "world is null");
    REFUSES(pierce_bodies_of(w, 0, NULL, &count), "bodies is null");
    REFUSES(pierce_bodies_of(w, 0, &of, NULL), "count is null");
    REFUSES(pierce_replicate(NULL, 0, 1, &first), "world is null");
    REFUSES(pierce_replicate(w, 0, 1, NULL), "first is null");
    REFUSES(pierce_replicate(w, 3, 1, &first), "no world 3");
    REFUSES(pierce_copy_places(NULL, 0, 1), "world is null");
    REFUSES(pierce_copy_places(w, 0, 1), "world");
    REFUSES(pierce_remove_world(NULL, 0), "world is null");
    WORKS(pierce_remove_world(w, 8)); /* it has no bodies */
    REFUSES(pierce_set_world_active(NULL, 0, 1), "world is null");
    REFUSES(pierce_set_world_active(w, PIERCE_ALL_WORLDS, 1), "");
    REFUSES(pierce_world_offsets(NULL, &offsets), "world is null");
    REFUSES(pierce_world_offsets(w, NULL), "offsets is null");
    offsets.struct_size = 2;
    REFUSES(pierce_world_offsets(w, &offsets), "struct_size");
}

static void places(scene* s, pierce_body_id stale) {
    pierce_world* w = s->world;
    const pierce_body_id one[2] = {s->above, stale};
    const float* p = s->shape.positions;
    const float f[14] = {0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1};
    const double d[14] = {0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1};
    REFUSES(pierce_set_pose(NULL, s->above, d), "world is null");
    REFUSES(pierce_set_pose(w, s->above, NULL), "pose is null");
    REFUSES(pierce_set_pose(w, stale, d), "was removed");
    REFUSES(pierce_set_poses(NULL, one, 1, d), "world is null");
    REFUSES(pierce_set_poses(w, NULL, 1, d), "bodies is null");
    REFUSES(pierce_set_poses(w, one, too_many, d), "bodies has too many");
    REFUSES(pierce_set_poses(w, one, 1, NULL), "poses is null");
    REFUSES(pierce_set_poses(w, one, 2, d), "was removed");
    WORKS(pierce_set_poses(w, NULL, 0, NULL));
    REFUSES(pierce_set_poses_float(NULL, one, 1, f), "world is null");
    REFUSES(pierce_set_poses_float(w, NULL, 1, f), "bodies is null");
    REFUSES(pierce_set_poses_float(w, one, 1, NULL), "poses is null");
    REFUSES(pierce_set_poses_float(w, one, 2, f), "was removed");
    REFUSES(pierce_set_positions(NULL, s->above, p, torus_vertices), "world is null");
    REFUSES(pierce_set_positions(w, s->above, p, torus_vertices), "does not deform");
    REFUSES(pierce_set_positions(w, s->above, NULL, torus_vertices), "positions is null");
    REFUSES(pierce_set_positions(w, stale, p, torus_vertices), "was removed");
    REFUSES(pierce_set_positions_many(NULL, one, 1, p, torus_vertices), "world is null");
    REFUSES(pierce_set_positions_many(w, NULL, 1, p, torus_vertices), "bodies is null");
    REFUSES(pierce_set_positions_many(w, one, 1, NULL, torus_vertices), "positions is null");
    REFUSES(pierce_set_positions_many(w, one, 1, p, torus_vertices), "does not deform");
    REFUSES(pierce_set_motion(NULL, s->above, p, p, torus_vertices), "world is null");
    REFUSES(pierce_set_motion(w, s->above, p, p, torus_vertices), "");
    REFUSES(pierce_set_motion(w, s->above, NULL, p, torus_vertices), "start is null");
    REFUSES(pierce_set_motion(w, s->above, p, NULL, torus_vertices), "positions is null");
    REFUSES(pierce_set_motion_poses(NULL, s->above, d, d), "world is null");
    REFUSES(pierce_set_motion_poses(w, s->above, NULL, d), "start is null");
    REFUSES(pierce_set_motion_poses(w, s->above, d, NULL), "pose is null");
    REFUSES(pierce_set_motion_poses(w, stale, d, d), "was removed");
    REFUSES(pierce_forget_sides(NULL), "world is null");
    /* What was refused has changed nothing. */
    {
        double at[3];
        WORKS(pierce_vertex_position(w, s->above, 0, at));
        CHECK(at[2] != 0);
    }
}

/* The world's backend runs on the host. */
static void device(scene* s) {
    pierce_world* w = s->world;
    const pierce_body_id one = s->above;
    const float f[3] = {0, 0, 0};
    const double d[7] = {0};
    pierce_device_contact_list solids = {.struct_size = sizeof solids}, sheets = solids;
    REFUSES(pierce_set_device_positions(NULL, &one, 1, f), "world is null");
    REFUSES(pierce_set_device_positions(w, &one, 1, NULL), "positions is null");
    REFUSES(pierce_set_device_positions(w, NULL, 1, f), "bodies is null");
    REFUSES(pierce_set_device_positions(w, &one, 1, f), "");
    REFUSES(pierce_set_device_motion(NULL, one, f, f), "world is null");
    REFUSES(pierce_set_device_motion(w, one, NULL, f), "start is null");
    REFUSES(pierce_set_device_motion(w, one, f, NULL), "positions is null");
    REFUSES(pierce_set_device_motion(w, one, f, f), "");
    REFUSES(pierce_set_device_poses(NULL, &one, 1, d), "world is null");
    REFUSES(pierce_set_device_poses(w, &one, 1, NULL), "poses is null");
    REFUSES(pierce_set_device_poses(w, &one, 1, d), "");
    REFUSES(pierce_set_device_poses_float(NULL, &one, 1, f), "world is null");
    REFUSES(pierce_set_device_poses_float(w, &one, 1, f), "");
    REFUSES(pierce_set_stream(NULL, NULL), "world is null");
    REFUSES(pierce_set_stream(w, w), "");
    REFUSES(pierce_device_contacts(NULL, 0, &solids, &sheets), "world is null");
    REFUSES(pierce_device_contacts(w, 0, NULL, &sheets), "solids is null");
    REFUSES(pierce_device_contacts(w, 0, &solids, NULL), "sheets is null");
    REFUSES(pierce_device_contacts(w, 0, &solids, &sheets), "");
    sheets.struct_size = 5;
    REFUSES(pierce_device_contacts(w, 0, &solids, &sheets), "struct_size");
}

static void steps(scene* s) {
    pierce_world* w = s->world;
    pierce_step_stats stats = {.struct_size = sizeof stats};
    pierce_plan_info plan = {.struct_size = sizeof plan};
    const pierce_body_box* boxes = NULL;
    pierce_contact_list list = {0}, narrow, missing = {NULL, 3, sizeof(pierce_contact)};
    pierce_translation way = {.struct_size = sizeof way};
    pierce_reduced_contact reduced[1];
    pierce_kept_contacts* kept = NULL;
    size_t count = 0;
    uint64_t number = 0;
    REFUSES(pierce_detect(NULL), "world is null");
    WORKS(pierce_detect(w));
    REFUSES(pierce_stats(NULL, &stats), "world is null");
    REFUSES(pierce_stats(w, NULL), "stats is null");
    REFUSES(pierce_plan(NULL, &plan), "world is null");
    REFUSES(pierce_plan(w, NULL), "plan is null");
    stats.struct_size = plan.struct_size = sizeof(size_t);
    REFUSES(pierce_stats(w, &stats), "struct_size");
    REFUSES(pierce_plan(w, &plan), "struct_size");
    REFUSES(pierce_body_boxes(NULL, &boxes, &count), "world is null");
    REFUSES(pierce_body_boxes(w, NULL, &count), "boxes is null");
    REFUSES(pierce_body_boxes(w, &boxes, NULL), "count is null");
    REFUSES(pierce_contacts(NULL, &list), "world is null");
    REFUSES(pierce_contacts(w, NULL), "list is null");
    REFUSES(pierce_keep_contacts(NULL, &kept, &list), "world is null");
    REFUSES(pierce_keep_contacts(w, NULL, &list), "kept is null");
    REFUSES(pierce_keep_contacts(w, &kept, NULL), "list is null");
    CHECK(kept == NULL && list.contacts == NULL);
    pierce_release_contacts(NULL);
    WORKS(pierce_contacts(w, &list));
    narrow = list;
    narrow.stride = 200;
    REFUSES(pierce_contact_feature(NULL, &number), "contact is null");
    REFUSES(pierce_contact_feature(list.contacts, NULL), "feature is null");
    REFUSES(pierce_contact_hash(NULL, &number), "list is null");
    REFUSES(pierce_contact_hash(&list, NULL), "hash is null");
    REFUSES(pierce_contact_hash(&narrow, &number), "stride of 200");
    REFUSES(pierce_contact_hash(&missing, &number), "list is null");
    REFUSES(pierce_contact_changes(NULL, &list, NULL, NULL, NULL, NULL, NULL, NULL), "earlier");
    REFUSES(pierce_contact_changes(&list, NULL, NULL, NULL, NULL, NULL, NULL, NULL), "later");
    REFUSES(pierce_contact_changes(&list, &narrow, NULL, NULL, NULL, NULL, NULL, NULL), "later");
    REFUSES(pierce_reduce(NULL, 8, reduced, &count), "list is null");
    REFUSES(pierce_reduce(&list, 8, NULL, &count), "reduced is null");
    REFUSES(pierce_reduce(&list, 8, reduced, NULL), "reduced_count is null");
    REFUSES(pierce_reduce(&list, 5, reduced, &count), "");
    REFUSES(pierce_least_translation(NULL, &way), "list is null");
    REFUSES(pierce_least_translation(&list, NULL), "translation is null");
    way.struct_size = 0;
    REFUSES(pierce_least_translation(&list, &way), "struct_size");
}

static void questions(scene* s, pierce_body_id stale) {
    pierce_world* w = s->world;
    pierce_explanation why = {.struct_size = sizeof why};
    pierce_translation way = {.struct_size = sizeof way};
    pierce_common_volume common = {.struct_size = sizeof common};
    const pierce_impact* impacts = NULL;
    const double d[3] = {0, 0, 1}, bad[3] = {0, (double)NAN, 1};
    const double elsewhere[7] = {0, 0, 2, 0, 0, 0, 1};
    pierce_ray_hit hit;
    pierce_probe_contact touched;
    size_t count = 0;
    REFUSES(pierce_explain(NULL, s->above, s->below, 0, &why), "world is null");
    REFUSES(pierce_explain(w, stale, s->below, 0, &why), "was removed");
    REFUSES(pierce_explain(w, s->above, 0, 0, &why), "body handle is null");
    REFUSES(pierce_explain(w, s->above, s->below, torus_vertices, &why), "vertex");
    REFUSES(pierce_explain(w, s->above, s->below, 0, NULL), "explanation is null");
    REFUSES(pierce_parting(NULL, s->above, s->below, &way), "world is null");
    REFUSES(pierce_parting(w, s->above, s->above, &way), "itself");
    REFUSES(pierce_parting(w, s->above, stale, &way), "was removed");
    REFUSES(pierce_parting(w, s->above, s->below, NULL), "translation is null");
    REFUSES(pierce_overlap(NULL, s->above, s->below, 0.9, &common), "world is null");
    REFUSES(pierce_overlap(w, s->above, s->above, 0.9, &common), "itself");
    REFUSES(pierce_overlap(w, s->above, stale, 0.9, &common), "was removed");
    REFUSES(pierce_overlap(w, s->above, s->below, (double)NAN, &common), "cosine");
    REFUSES(pierce_overlap(w, s->above, s->below, 0.9, NULL), "common is null");
    why.struct_size = way.struct_size = common.struct_size = 7;
    REFUSES(pierce_explain(w, s->above, s->below, 0, &why), "struct_size");
    REFUSES(pierce_parting(w, s->above, s->below, &way), "struct_size");
    REFUSES(pierce_overlap(w, s->above, s->below, 0.9, &common), "struct_size");
    REFUSES(pierce_impacts(NULL, 1, &impacts, &count), "world is null");
    REFUSES(pierce_impacts(w, 1, NULL, &count), "impacts is null");
    REFUSES(pierce_impacts(w, 1, &impacts, NULL), "count is null");
    REFUSES(pierce_impacts_ahead(NULL, NULL, 0, NULL, 1, &impacts, &count), "world is null");
    REFUSES(pierce_impacts_ahead(w, &s->above, 1, NULL, 1, &impacts, &count), "poses is null");
    REFUSES(pierce_impacts_ahead(w, NULL, 0, NULL, 1, NULL, &count), "impacts is null");
    REFUSES(pierce_impacts_ahead(w, NULL, 0, NULL, 1, &impacts, NULL), "count is null");
    REFUSES(pierce_impacts_ahead(w, &stale, 1, elsewhere, 1, &impacts, &count), "was removed");
    REFUSES(pierce_cast_rays(NULL, d, d, 1, &hit), "world is null");
    REFUSES(pierce_cast_rays(w, NULL, d, 1, &hit), "origin is null");
    REFUSES(pierce_cast_rays(w, d, NULL, 1, &hit), "directions is null");
    REFUSES(pierce_cast_rays(w, d, d, 1, NULL), "hits is null");
    REFUSES(pierce_cast_rays(w, d, bad, 1, &hit), "finite");
    REFUSES(pierce_cast_rays(w, bad, d, 1, &hit), "finite");
    REFUSES(pierce_cast_rays(w, d, d, too_many, &hit), "too many");
    REFUSES(pierce_probe(NULL, d, d, 1, 1, NULL, 0, &touched), "world is null");
    REFUSES(pierce_probe(w, NULL, d, 1, 1, NULL, 0, &touched), "points is null");
    REFUSES(pierce_probe(w, d, NULL, 1, 1, NULL, 0, &touched), "normals is null");
    REFUSES(pierce_probe(w, d, bad, 1, 1, NULL, 0, &touched), "finite");
    REFUSES(pierce_probe(w, d, d, 1, -1, NULL, 0, &touched), "radius");
    REFUSES(pierce_probe(w, d, d, 1, 1, NULL, 1, &touched), "others is null");
    REFUSES(pierce_probe(w, d, d, 1, 1, &stale, 1, &touched), "was removed");
    REFUSES(pierce_probe(w, d, d, 1, 1, NULL, 0, NULL), "contacts is null");
    /* Bodies have moved since. */
    WORKS(pierce_set_pose(w, s->above, elsewhere));
    why.struct_size = sizeof why;
    REFUSES(pierce_explain(w, s->above, s->below, 0, &why), "");
    REFUSES(pierce_cast_rays(w, d, d, 1, &hit), "");
    REFUSES(pierce_probe(w, d, d, 1, 1, NULL, 0, &touched), "");
}

int main(void) {
    scene s;
    pierce_body_id stale = 0;
    CHECK(strcmp(pierce_last_error(), "") == 0);
    CHECK(pierce_version()[0] != '\0');
    structs();
    worlds();
    missing_backend();
    make_scene(&s, NULL, NULL);
    WORKS(pierce_add_fixed_body(s.world, s.mesh, NULL, &stale));
    WORKS(pierce_remove_body(s.world, stale));
    meshes(&s);
    bodies(&s, stale);
    worlds_within(&s);
    places(&s, stale);
    device(&s);
    steps(&s);
    questions(&s, stale);
    pierce_destroy_world(s.world);
    return failures != 0;
}
