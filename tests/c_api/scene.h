/* Two tori that overlap, and what tests in C say when something is wrong. */
#ifndef PIERCE_TESTS_C_API_SCENE_H
#define PIERCE_TESTS_C_API_SCENE_H

#include <math.h>
#include <pierce/pierce.h>
#include <stdio.h>
#include <string.h>

enum { torus_around = 24, torus_across = 12, torus_vertices = torus_around * torus_across };
enum { torus_triangles = 2 * torus_vertices };

static int failures = 0;

/* Ends nothing, so that one run tells all. */
#define CHECK(condition) \
    ((condition) ? (void)0 : (++failures, (void)printf("line %d: %s\n", __LINE__, #condition)))

/* A call that works. */
#define WORKS(call) expect((call), PIERCE_OK, "", #call, __LINE__)
/* A call that is refused with a message that has these words. */
#define REFUSES(call, words) expect((call), PIERCE_INVALID_INPUT, words, #call, __LINE__)

static void expect(pierce_status status, pierce_status expected, const char* words,
                   const char* call, int line) {
    if (status == expected && strstr(pierce_last_error(), words) != NULL) return;
    ++failures;
    printf("line %d: %s: status %d, %s\n", line, call, (int)status, pierce_last_error());
}

typedef struct torus {
    float positions[3 * torus_vertices];
    uint32_t triangles[3 * torus_triangles];
} torus;

/* A torus around the z axis, with radii 1 and 0.4. */
static void make_torus(torus* t) {
    const double turn = 8 * atan(1.0);
    uint32_t i, k;
    uint32_t* next = t->triangles;
    for (i = 0; i < torus_around; ++i)
        for (k = 0; k < torus_across; ++k) {
            const double u = turn * i / torus_around, v = turn * k / torus_across;
            float* p = t->positions + 3 * (i * torus_across + k);
            p[0] = (float)((1 + 0.4 * cos(v)) * cos(u));
            p[1] = (float)((1 + 0.4 * cos(v)) * sin(u));
            p[2] = (float)(0.4 * sin(v));
        }
    for (i = 0; i < torus_around; ++i)
        for (k = 0; k < torus_across; ++k) {
            const uint32_t j = (i + 1) % torus_around, l = (k + 1) % torus_across;
            const uint32_t a = i * torus_across + k, b = j * torus_across + k,
                           c = j * torus_across + l, d = i * torus_across + l;
            const uint32_t quad[6] = {a, b, c, a, c, d};
            memcpy(next, quad, sizeof quad);
            next += 6;
        }
}

static const double pose_above[7] = {0.3, 0.1, 0.5, 0.1, 0.2, 0.05, 1};

typedef struct scene {
    torus shape;
    pierce_world* world;
    pierce_mesh_id mesh;
    pierce_body_id below, above;
} scene;

/* The first torus is fixed, and the second one overlaps it. */
static void make_scene(scene* s, const pierce_settings* settings,
                       const pierce_backend_options* backend) {
    make_torus(&s->shape);
    WORKS(pierce_create_world(settings, backend, &s->world));
    WORKS(pierce_add_mesh(s->world, "torus", s->shape.positions, torus_vertices, s->shape.triangles,
                          torus_triangles, NULL, &s->mesh));
    WORKS(pierce_add_fixed_body(s->world, s->mesh, NULL, &s->below));
    WORKS(pierce_add_rigid_body(s->world, s->mesh, pose_above, &s->above));
}

#endif
