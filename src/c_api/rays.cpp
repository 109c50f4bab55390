#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/world_state.hpp"
#include "pierce/c/queries.h"

using namespace pierce::c;

pierce_status pierce_cast_rays(pierce_world* world, const double* origin, const double* directions,
                               size_t count, pierce_ray_hit* hits) {
    return guarded([&] {
        auto& inner = world_of(world);
        required(origin, "origin");
        const auto lines = vectors(directions, count, "directions");
        if (count > 0) required(hits, "hits");
        for (const auto& hit : inner.cast_rays({origin[0], origin[1], origin[2]}, lines)) {
            *hits = {};
            if (hit) {
                hits->body = number(hit->body);
                hits->t = hit->t;
                copy_to(hits->normal, hit->normal);
                hits->triangle = hit->triangle;
            }
            ++hits;
        }
    });
}

pierce_status pierce_probe(pierce_world* world, const double* points, const double* normals,
                           size_t count, double radius, const pierce_body_id* others,
                           size_t other_count, pierce_probe_contact* contacts) {
    return guarded([&] {
        auto& inner = world_of(world);
        const auto places = vectors(points, count, "points");
        const auto directions = vectors(normals, count, "normals");
        const auto bodies = body_handles(others, other_count, "others");
        if (count > 0) required(contacts, "contacts");
        for (const auto& contact : inner.probe(places, directions, radius, bodies)) {
            *contacts = {};
            if (contact) {
                contacts->body = number(contact->body);
                contacts->distance = contact->distance;
                copy_to(contacts->normal, contact->normal);
                contacts->triangle = contact->triangle;
            }
            ++contacts;
        }
    });
}
