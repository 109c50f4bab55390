#include <pierce/pierce.h>
#include <stdio.h>

/* Eight corners, counted in binary: x, y, z. Triangles are counter-clockwise seen from outside. */
static const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                                0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
static const uint32_t triangles[] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                     2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};

static int is_ok(pierce_status status) {
    if (status != PIERCE_OK) fprintf(stderr, "error %d: %s\n", (int)status, pierce_last_error());
    return status == PIERCE_OK;
}

int main(void) {
    const double pose[7] = {0.25, 0.25, 0.9, 0, 0, 0, 1};
    pierce_world* world = NULL;
    pierce_mesh_id box = 0;
    pierce_body_id below = 0, above = 0;
    pierce_contact_list list = {0};
    const int ok = is_ok(pierce_create_world(NULL, NULL, &world)) &&
                   is_ok(pierce_add_mesh(world, "box", corners, 8, triangles, 12, NULL, &box)) &&
                   is_ok(pierce_add_fixed_body(world, box, NULL, &below)) &&
                   is_ok(pierce_add_rigid_body(world, box, pose, &above)) &&
                   is_ok(pierce_detect(world)) && is_ok(pierce_contacts(world, &list));
    for (size_t i = 0; i < list.count; ++i) {
        const pierce_contact* c = pierce_contact_at(&list, i);
        printf("vertex %u, depth %.3f, at %.2f %.2f %.2f\n", (unsigned)c->vertex, -c->distance,
               c->point_b[0], c->point_b[1], c->point_b[2]);
    }
    pierce_destroy_world(world);
    return ok ? 0 : 1;
}
