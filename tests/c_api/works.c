/* Every call of the C API, where it works. Prints nothing if all is well. */
#include <stdlib.h>

#include "scene.h"

static double dot(const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* What a contact says of itself holds. */
static void contacts_are_sound(const scene* s, const pierce_contact_list* list) {
    size_t i;
    for (i = 0; i < list->count; ++i) {
        const pierce_contact* c = pierce_contact_at(list, i);
        const double way[3] = {c->point_b[0] - c->point_a[0], c->point_b[1] - c->point_a[1],
                               c->point_b[2] - c->point_a[2]};
        CHECK(c->a == s->below && c->b == s->above);
        CHECK(fabs(dot(c->normal, c->normal) - 1) < 1e-9);
        CHECK(fabs(dot(way, c->normal) - c->distance) < 1e-6);
        CHECK(fabs(c->barycentric[0] + c->barycentric[1] + c->barycentric[2] - 1) < 1e-9);
        CHECK(c->triangle < torus_triangles);
    }
}

static void steps(void) {
    scene s;
    pierce_contact_list list = {0};
    pierce_step_stats stats = {.struct_size = sizeof stats};
    pierce_plan_info plan = {.struct_size = sizeof plan};
    const pierce_body_box* boxes = NULL;
    const char* text = NULL;
    size_t count = 0;
    uint64_t feature = 0;
    make_scene(&s, NULL, NULL);
    WORKS(pierce_backend(s.world, &text));
    CHECK(text != NULL && text[0] != '\0');
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    CHECK(list.count > 10 && list.stride == sizeof(pierce_contact));
    contacts_are_sound(&s, &list);
    WORKS(pierce_contact_feature(list.contacts, &feature));
    CHECK(feature >> 34 == list.contacts->vertex);

    WORKS(pierce_stats(s.world, &stats));
    CHECK(stats.contacts == list.count && stats.pairs == 1 && stats.touching_pairs == 1);
    CHECK(stats.status == 0 && stats.stage_count > 3 && stats.stages[0].name[0] != '\0');
    WORKS(pierce_plan(s.world, &plan));
    CHECK(plan.fixed_bodies == 1 && plan.rigid_bodies == 1 && plan.note_count == 0);
    CHECK(plan.settings->coverage == PIERCE_COVERAGE_OVERLAPS && plan.stage_count > 3);
    WORKS(pierce_body_boxes(s.world, &boxes, &count));
    CHECK(count == 2 && boxes[0].body == s.below && boxes[0].upper[0] > 1.3);
    pierce_destroy_world(s.world);
}

/* A step in which nothing has changed; contacts of steps before, which nobody writes any more. */
static void rest(void) {
    scene s;
    pierce_contact_list list = {0}, early = {0}, late = {0};
    pierce_kept_contacts *first = NULL, *second = NULL;
    pierce_step_stats stats = {.struct_size = sizeof stats};
    uint64_t hash = 0, of_early = 1, of_late = 2;
    uint32_t step;
    const double far_away[7] = {0, 0, 9, 0, 0, 0, 1};
    make_scene(&s, NULL, NULL);
    for (step = 0; step < 4; ++step) {
        WORKS(pierce_detect(s.world));
        WORKS(pierce_stats(s.world, &stats));
        CHECK(stats.at_rest == (step >= 2) && (stats.stage_count == 0) == (step >= 2));
        WORKS(pierce_contacts(s.world, &list));
        CHECK(stats.contacts == list.count && list.count > 10 && list.contacts->age == step);
        if (step == 1) WORKS(pierce_keep_contacts(s.world, &first, &early));
    }
    WORKS(pierce_contact_hash(&list, &hash));
    WORKS(pierce_keep_contacts(s.world, &second, &late));
    CHECK(late.contacts == list.contacts && late.count == list.count);
    WORKS(pierce_set_pose(s.world, s.above, far_away));
    WORKS(pierce_detect(s.world));
    WORKS(pierce_stats(s.world, &stats));
    CHECK(stats.at_rest == 0 && stats.contacts == 0);
    pierce_destroy_world(s.world);
    WORKS(pierce_contact_hash(&early, &of_early));
    WORKS(pierce_contact_hash(&late, &of_late));
    CHECK(hash == of_early && hash == of_late);
    CHECK(early.contacts->age == 1 && late.contacts->age == 3);
    CHECK(early.stride == sizeof(pierce_contact) && late.stride == early.stride);
    pierce_release_contacts(first);
    pierce_release_contacts(second);
}

/* Contacts go out as they are, and come back in where they lie, copied, or further apart. */
static void lists(void) {
    scene s;
    pierce_contact_list list = {0}, copy = {0}, wide = {0}, none = {0};
    uint64_t hash = 0, of_copy = 0, of_wide = 0, of_none = 0;
    size_t i, began = 9, stayed = 9, ended = 9, kept = 0;
    uint32_t* places;
    pierce_reduced_contact* reduced;
    pierce_translation way = {.struct_size = sizeof way};
    char* bytes;
    make_scene(&s, NULL, NULL);
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    bytes = malloc(list.count * (list.stride + 24) + 8);
    /* 8 bytes off what the library's own records are aligned to. */
    copy.contacts = (const pierce_contact*)(void*)(bytes + 8);
    copy.count = list.count;
    copy.stride = list.stride;
    memcpy(bytes + 8, list.contacts, list.count * list.stride);
    WORKS(pierce_contact_hash(&list, &hash));
    WORKS(pierce_contact_hash(&copy, &of_copy));
    wide = copy;
    wide.stride = list.stride + 24;
    for (i = 0; i < list.count; ++i)
        memcpy(bytes + 8 + i * wide.stride, pierce_contact_at(&list, i), list.stride);
    WORKS(pierce_contact_hash(&wide, &of_wide));
    WORKS(pierce_contact_hash(&none, &of_none));
    CHECK(hash == of_copy && hash == of_wide && hash != of_none);

    places = malloc(3 * list.count * sizeof *places);
    WORKS(pierce_contact_changes(&wide, &list, places, &began, places + list.count, &stayed,
                                 places + 2 * list.count, &ended));
    CHECK(began == 0 && stayed == list.count && ended == 0 && places[list.count + 1] == 1);
    WORKS(pierce_contact_changes(&none, &list, places, &began, NULL, NULL, NULL, &ended));
    CHECK(began == list.count && ended == 0);

    reduced = malloc(list.count * sizeof *reduced);
    WORKS(pierce_reduce(&list, 8, reduced, &kept));
    CHECK(kept > 0 && kept <= 8 && reduced[0].contact < list.count && reduced[0].weight > 0);
    WORKS(pierce_reduce(&none, 8, NULL, &kept));
    CHECK(kept == 0);
    WORKS(pierce_least_translation(&list, &way));
    CHECK(way.exists == 0 || way.depth > 0);
    free(reduced);
    free(places);
    free(bytes);
    pierce_destroy_world(s.world);
}

static void questions(void) {
    scene s;
    pierce_contact_list list = {0};
    pierce_explanation why = {.struct_size = sizeof why};
    pierce_translation way = {.struct_size = sizeof way};
    pierce_common_volume common = {.struct_size = sizeof common};
    const pierce_impact* impacts = NULL;
    const pierce_impact* ahead = NULL;
    const double origin[3] = {0, 0, 9}, lines[6] = {0.1, 0, -1, 0, 0, 1};
    const double points[6] = {1, 0, 0, 40, 0, 0}, normals[6] = {0, 0, 1, 0, 0, 1};
    const double far_away[7] = {0, 0, 9, 0, 0, 0, 1}, beyond[7] = {0, 0, -9, 0, 0, 0, 1};
    pierce_ray_hit hits[2];
    pierce_probe_contact touched[2];
    size_t count = 0;
    make_scene(&s, NULL, NULL);
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    WORKS(pierce_explain(s.world, list.contacts->source == 0 ? s.below : s.above,
                         list.contacts->source == 0 ? s.above : s.below, list.contacts->vertex,
                         &why));
    CHECK(why.reason == PIERCE_REASON_CONTACT && strlen(why.text) > 10 && why.contact != NULL);
    CHECK(why.contact != NULL && why.contact->distance == list.contacts->distance);
    WORKS(pierce_cast_rays(s.world, origin, lines, 2, hits));
    CHECK(hits[0].body == s.above || hits[0].body == s.below || hits[0].body == 0);
    CHECK(hits[1].body == 0 && hits[1].t == 0);
    WORKS(pierce_probe(s.world, points, normals, 2, 0.1, &s.below, 1, touched));
    CHECK(touched[0].body == s.below && touched[0].distance < -0.1 && touched[1].body == 0);
    WORKS(pierce_parting(s.world, s.below, s.above, &way));
    CHECK(way.exists == 1 && way.depth > 0 && fabs(dot(way.direction, way.direction) - 1) < 1e-9);
    WORKS(pierce_overlap(s.world, s.below, s.above, 0.9, &common));
    CHECK(common.exists == 1 && common.volume > 0 && common.patch_count > 0);
    CHECK(common.patch_count > 0 && common.patches[0].depth > 0);
    WORKS(pierce_impacts(s.world, 1, &impacts, &count));
    CHECK(count == 0);
    WORKS(pierce_set_pose(s.world, s.above, far_away));
    WORKS(pierce_impacts_ahead(s.world, &s.above, 1, beyond, 4, &impacts, &count));
    CHECK(count == 4 && impacts[0].b == s.above && impacts[0].time < 0.5);
    CHECK(count == 4 && impacts[0].start_b[2] - impacts[0].start_a[2] > 7);
    CHECK(count == 4 && fabs(impacts[0].start_b[2] - impacts[0].start_a[2] -
                             impacts[0].gap / impacts[0].normal[2]) < 1e-4);
    WORKS(pierce_set_motion_poses(s.world, s.above, far_away, beyond));
    WORKS(pierce_impacts(s.world, 1, &impacts, &count));
    CHECK(count == 1 && impacts[0].a == s.below && impacts[0].b == s.above);
    CHECK(count == 1 && impacts[0].time > 0.4 && impacts[0].time < 0.5);
    WORKS(pierce_impacts_ahead(s.world, &s.above, 1, far_away, 4, &ahead, &count));
    CHECK(ahead != impacts && impacts[0].a == s.below && impacts[0].b == s.above);
    WORKS(pierce_overlap(s.world, s.below, s.above, 0.9, &common));
    CHECK(common.exists == 0 && common.volume == 0 && common.patch_count == 0);
    WORKS(pierce_parting(s.world, s.below, s.above, &way));
    CHECK(way.exists == 0 && way.depth == 0);
    pierce_destroy_world(s.world);
}

static void places(void) {
    scene s;
    pierce_body_id soft, both[2];
    pierce_contact_list list = {0};
    double all[3 * torus_vertices], pose[7];
    double at[3], poses[14] = {0, 0, 0, 0, 0, 0, 1, 0, 0, 9, 0, 0, 0, 1};
    float float_poses[7] = {0, 0, 0.5f, 0, 0, 0, 1};
    float moved[6 * torus_vertices];
    uint32_t motion = 9;
    pierce_mesh_id of = 0;
    size_t i;
    make_scene(&s, NULL, NULL);
    for (i = 0; i < 6 * torus_vertices; ++i)
        moved[i] = s.shape.positions[i % (3 * torus_vertices)] + (i % 3 == 0 ? 0.5f : 0);
    WORKS(pierce_add_deforming_body(s.world, s.mesh, NULL, 0, &soft));
    WORKS(pierce_motion_of(s.world, soft, &motion));
    CHECK(motion == PIERCE_DEFORMING);
    WORKS(pierce_mesh_of(s.world, soft, &of));
    CHECK(of == s.mesh);
    WORKS(pierce_set_positions(s.world, soft, moved, torus_vertices));
    WORKS(pierce_vertex_position(s.world, soft, 0, at));
    CHECK(at[0] == (double)moved[0]);
    WORKS(pierce_vertex_positions(s.world, soft, all, torus_vertices));
    for (size_t i = 0; i < 3 * torus_vertices; ++i) CHECK(all[i] == (double)moved[i]);
    WORKS(pierce_set_positions_many(s.world, &soft, 1, moved, torus_vertices));
    WORKS(pierce_set_motion(s.world, soft, s.shape.positions, moved, torus_vertices));
    WORKS(pierce_set_mesh(s.world, soft, s.mesh, moved, torus_vertices));
    WORKS(pierce_set_mesh(s.world, s.above, s.mesh, NULL, 0));
    WORKS(pierce_forget_sides(s.world));
    WORKS(pierce_remove_body(s.world, soft));
    both[0] = s.below;
    both[1] = s.above;
    WORKS(pierce_set_poses(s.world, both, 2, poses));
    WORKS(pierce_vertex_position(s.world, s.above, 0, at));
    CHECK(at[2] == 9);
    WORKS(pierce_pose_of(s.world, s.above, pose));
    for (int k = 0; k < 7; ++k) CHECK(pose[k] == poses[7 + k]);
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    CHECK(list.count == 0);
    WORKS(pierce_set_poses_float(s.world, &s.above, 1, float_poses));
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    CHECK(list.count > 0);
    WORKS(pierce_set_pose(s.world, s.above, poses + 7));
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    CHECK(list.count == 0);
    pierce_destroy_world(s.world);
}

/* A place that is not finite is no error, but counted. */
static void unusable_places(void) {
    scene s;
    double pose[7] = {0, 0, 0, 0, 0, 0, 1};
    pierce_step_stats stats = {.struct_size = sizeof stats};
    make_scene(&s, NULL, NULL);
    pose[0] = (double)NAN;
    WORKS(pierce_set_pose(s.world, s.above, pose));
    WORKS(pierce_detect(s.world));
    WORKS(pierce_stats(s.world, &stats));
    CHECK(stats.excluded_bodies == 1 && (stats.status & PIERCE_BODY_EXCLUDED) != 0);
    pierce_destroy_world(s.world);
}

/* What a pair filter was asked, and answers. There is one pair, so one thread at a time writes. */
typedef struct question {
    pierce_body_id a, b;
    int calls, answer;
} question;

static int answer(pierce_body_id a, pierce_body_id b, void* user) {
    question* asked = user;
    asked->a = a;
    asked->b = b;
    ++asked->calls;
    return asked->answer;
}

static void pair_filters(void) {
    scene s;
    pierce_contact_list list = {0};
    question asked = {0, 0, 0, 0};
    make_scene(&s, NULL, NULL);
    WORKS(pierce_set_pair_filter(s.world, answer, &asked));
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    CHECK(list.count == 0 && asked.calls == 1 && asked.a == s.below && asked.b == s.above);
    asked.answer = -1;
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    CHECK(list.count > 10 && asked.calls == 2);
    asked.answer = 0;
    WORKS(pierce_set_pair_filter(s.world, NULL, &asked));
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    CHECK(list.count > 10 && asked.calls == 2);
    pierce_destroy_world(s.world);
}

static void filters(void) {
    scene s;
    pierce_filter filter;
    pierce_collision collision;
    pierce_contact_list list = {0};
    const int32_t* worlds = NULL;
    const pierce_body_id* bodies = NULL;
    const pierce_body_pair* excluded = NULL;
    pierce_offsets offsets = {.struct_size = sizeof offsets};
    int32_t first = 0;
    size_t count = 0, alone;
    make_scene(&s, NULL, NULL);
    WORKS(pierce_exclude(s.world, s.below, s.above));
    WORKS(pierce_excluded_pairs(s.world, &excluded, &count));
    CHECK(count == 1 && excluded[0].a == s.below && excluded[0].b == s.above);
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    CHECK(list.count == 0);
    WORKS(pierce_include(s.world, s.below, s.above));
    WORKS(pierce_default_filter(&filter, sizeof filter));
    CHECK(filter.groups == 1 && filter.world == PIERCE_ALL_WORLDS);
    filter.world = 5;
    WORKS(pierce_set_filter(s.world, s.above, &filter));
    filter.world = 0;
    WORKS(pierce_filter_of(s.world, s.above, &filter));
    CHECK(filter.world == 5);
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    alone = list.count;
    WORKS(pierce_replicate(s.world, 5, 2, &first));
    CHECK(first == 6);
    WORKS(pierce_worlds(s.world, &worlds, &count));
    CHECK(count == 3 && worlds[2] == 7);
    WORKS(pierce_bodies_of(s.world, 7, &bodies, &count));
    CHECK(count == 1);
    WORKS(pierce_copy_places(s.world, 5, 7));
    WORKS(pierce_detect(s.world));
    WORKS(pierce_world_offsets(s.world, &offsets));
    CHECK(offsets.world_count == 3 && offsets.solids[1] == alone && offsets.solids[3] == 3 * alone);
    WORKS(pierce_set_world_active(s.world, 6, 0));
    WORKS(pierce_remove_world(s.world, 7));
    WORKS(pierce_detect(s.world));
    WORKS(pierce_contacts(s.world, &list));
    CHECK(list.count == alone && alone > 0);

    WORKS(pierce_default_collision(&collision, sizeof collision));
    CHECK(collision.margin < 0 && collision.sheet == 0);
    collision.margin = 0.125;
    WORKS(pierce_set_collision(s.world, s.above, &collision));
    collision.margin = 0;
    WORKS(pierce_collision_of(s.world, s.above, &collision));
    CHECK(collision.margin == 0.125);
    pierce_destroy_world(s.world);
}

typedef struct bytes {
    char* begin;
    size_t size;
} bytes;

static int append(const void* more, size_t size, void* user) {
    bytes* all = user;
    char* grown = realloc(all->begin, all->size + size);
    if (grown == NULL) return 1;
    memcpy(grown + all->size, more, size);
    all->begin = grown;
    all->size += size;
    return 0;
}

static void saving(void) {
    scene s;
    bytes saved = {NULL, 0};
    pierce_world* again = NULL;
    pierce_contact_list list = {0}, of_again = {0};
    uint64_t hash = 0, hash_again = 1;
    make_scene(&s, NULL, NULL);
    WORKS(pierce_save(s.world, append, &saved));
    WORKS(pierce_restore(saved.begin, saved.size, NULL, &again));
    WORKS(pierce_detect(s.world));
    WORKS(pierce_detect(again));
    WORKS(pierce_contacts(s.world, &list));
    WORKS(pierce_contacts(again, &of_again));
    WORKS(pierce_contact_hash(&list, &hash));
    WORKS(pierce_contact_hash(&of_again, &hash_again));
    CHECK(list.count > 0 && hash == hash_again);
    WORKS(pierce_remove_body(again, s.above)); /* numbers stay valid */
    pierce_destroy_world(s.world);
    pierce_destroy_world(again);
    free(saved.begin);
}

static void count_progress(const char* what, double share, void* user) {
    CHECK(what[0] != '\0' && share >= 0 && share <= 1);
    ++*(int*)user;
}

static void meshes(void) {
    scene s;
    pierce_mesh_info info = {.struct_size = sizeof info};
    pierce_mesh_options options;
    pierce_shared_mesh* shared = NULL;
    pierce_mesh_id cut = 0, other = 0;
    pierce_mesh_check_options how;
    const pierce_mesh_report* report = NULL;
    const pierce_fixed_mesh* fixed = NULL;
    uint32_t given = 9;
    uint32_t is_convex = 1;
    int told = 0;
    make_scene(&s, NULL, NULL);
    WORKS(pierce_mesh(s.world, s.mesh, &info));
    CHECK(info.vertex_count == torus_vertices && info.triangle_count == torus_triangles);
    CHECK(info.closed == 1 && info.volume > 0 && strcmp(info.name, "torus") == 0);
    CHECK(info.inside == PIERCE_INSIDE_CLOSED && info.positions[0] == s.shape.positions[0]);
    CHECK(memcmp(info.triangles, s.shape.triangles, sizeof s.shape.triangles) == 0);
    WORKS(pierce_given_triangle(s.world, s.mesh, 7, &given));
    WORKS(pierce_is_convex(s.world, s.mesh, &is_convex));
    CHECK(is_convex == 0);
    CHECK(given == 7);
    WORKS(pierce_default_mesh_options(&options, sizeof options));
    options.progress = count_progress;
    options.user = &told;
    options.threads = 1;
    WORKS(pierce_add_changed_mesh(s.world, NULL, s.shape.positions, torus_vertices,
                                  s.shape.triangles, torus_triangles - 1, s.mesh, &options, &cut));
    WORKS(pierce_mesh(s.world, cut, &info));
    CHECK(info.boundary_edges == 3 && info.closed == 0 && info.name[0] == '\0');
    WORKS(pierce_remove_mesh(s.world, cut));
    WORKS(pierce_create_shared_mesh("shared", s.shape.positions, torus_vertices, s.shape.triangles,
                                    torus_triangles, NULL, &shared));
    WORKS(pierce_add_shared_mesh(s.world, shared, &other));
    pierce_destroy_shared_mesh(shared);
    WORKS(pierce_mesh(s.world, other, &info));
    CHECK(strcmp(info.name, "shared") == 0);
    WORKS(pierce_share_mesh(s.world, other, &shared));
    WORKS(pierce_remove_mesh(s.world, other));
    WORKS(pierce_add_shared_mesh(s.world, shared, &other));
    pierce_destroy_shared_mesh(shared);
    WORKS(pierce_mesh(s.world, other, &info));
    CHECK(strcmp(info.name, "shared") == 0);

    WORKS(pierce_default_mesh_check_options(&how, sizeof how));
    how.self_intersections = 1;
    WORKS(pierce_check_mesh(s.shape.positions, torus_vertices, s.shape.triangles,
                            torus_triangles - 1, &how, &report));
    CHECK(report->closed == 0 && report->triangles == torus_triangles - 1);
    CHECK(report->finding_count == 1 && report->findings[0].defect == PIERCE_BORDER_EDGE);
    CHECK(report->findings[0].count == 3 && report->findings[0].place_count == 3);
    CHECK(strcmp(report->findings[0].name, "border edges") == 0);
    CHECK(report->inside == PIERCE_INSIDE_WINDING && report->inside_text[0] != '\0');
    pierce_free_mesh_report(report);
    WORKS(pierce_fix_mesh(s.shape.positions, torus_vertices, s.shape.triangles, torus_triangles - 1,
                          &fixed));
    CHECK(fixed->triangle_count == torus_triangles && fixed->vertex_count == torus_vertices);
    CHECK(fixed->inside == PIERCE_INSIDE_WINDING && fixed->vertices[5] == 5);
    CHECK(fixed->done[0] != '\0' && fixed->struct_size == sizeof(pierce_fixed_mesh));
    pierce_free_fixed_mesh(fixed);
    pierce_destroy_world(s.world);
}

/* The same contacts on every backend that is here. */
static void backends(void) {
    uint32_t kind;
    uint64_t hashes[PIERCE_BACKEND_CUDA + 1] = {0};
    for (kind = 0; kind <= PIERCE_BACKEND_CUDA; ++kind) {
        scene s;
        pierce_settings settings;
        pierce_backend_options options;
        pierce_contact_list list = {0};
        if (pierce_check_backend(kind) != PIERCE_OK) continue;
        WORKS(pierce_default_settings(&settings, sizeof settings));
        settings.coverage = PIERCE_COVERAGE_COMPLETE;
        settings.margin = 0.05;
        WORKS(pierce_default_backend_options(&options, sizeof options));
        options.kind = kind;
        options.threads = 1;
        options.tree_builder = PIERCE_TREES_PLOC;
        make_scene(&s, &settings, &options);
        WORKS(pierce_detect(s.world));
        WORKS(pierce_contacts(s.world, &list));
        WORKS(pierce_contact_hash(&list, &hashes[kind]));
        CHECK(list.count > 0 && hashes[kind] == hashes[0]);
        pierce_destroy_world(s.world);
    }
}

int main(void) {
    char version[32];
    snprintf(version, sizeof version, "%d.%d.%d", PIERCE_VERSION_MAJOR, PIERCE_VERSION_MINOR,
             PIERCE_VERSION_PATCH);
    CHECK(strcmp(version, pierce_version()) == 0);
    steps();
    rest();
    lists();
    questions();
    places();
    unusable_places();
    filters();
    pair_filters();
    saving();
    meshes();
    backends();
    CHECK(strcmp(pierce_last_error(), "") == 0 || pierce_check_backend(4) != PIERCE_OK);
    return failures != 0;
}
