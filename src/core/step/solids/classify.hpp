#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/step/solids/rules.hpp"
#include "core/trace/meeting.hpp"

/// classify: which hits are contacts. The rules are those of Hermann, Faure and Raffin
/// (2008):
/// * R1: the ray leaves the target at its first crossing, so the vertex was inside.
/// * R2: the ray's first crossing of its own body leaves that body. The triangles around the vertex
///   are left aside.
/// * R3: the ray leaves the target first, or both bodies at the same place.
///
/// Together: the segment from vertex to hit lies in both bodies and ends on the target's surface.
namespace pierce::stages {

/// True for rays that leave their target at their first crossing: they start inside.
struct LeavesTarget {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const Hit> hits;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        return hits[i].triangle != no_triangle &&
               leads_out(rays[i], bodies[rays[i].target].surface(), hits[i].triangle);
    }
    /// [length] How far the ray gets; 0 if it starts on the surface.
    PIERCE_HD double way(std::uint32_t i) const {
        return meet(rays[i], bodies[rays[i].target].surface(), hits[i].triangle).t;
    }
};

/// Per ray of a sheet along a velocity: its hit counts if the vertex gets there, or comes from
/// there, by its motion relative to the place hit. The ray is turned along that motion. In the
/// published method, the vertex's own motion decides. If a vertex slides in a triangle, the ray
/// ahead and the ray behind both meet it; one meeting is enough.
struct RelateToLayer {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const RaySource> sources;
    View<Ray> rays;
    View<Hit> hits;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[2 * sources[i].pair + sources[i].side];
        if (!d.along_velocity || hits[i].triangle == no_triangle) return;
        const BodyView& body = bodies[d.target];
        Ray& ray = rays[i];
        const bool against = sources[i].side == 1;
        if (against && lies_in(ray, body.surface(), hits[i].triangle)) hits[i] = {};
        if (body.collision.self == SelfCollision::published || hits[i].triangle == no_triangle)
            return;
        const Meeting m = meet(ray, body.surface(), hits[i].triangle);
        const Triangle& t = body.mesh.triangles[hits[i].triangle];
        Vec3d way = ray.origin - to_double(body.start[sources[i].item]);
        Vec3d corner[3];
        for (int k = 0; k < 3; ++k) {
            corner[k] = to_double(body.positions[t.vertex[k]]);
            way -= m.barycentric[k] * (corner[k] - to_double(body.start[t.vertex[k]]));
        }
        const bool moves = length_squared(way) > 0;
        ray.direction = normalized(against ? -way : way);
        ray.t_max = length(way);
        const Crossing crossing = moves ? cross_triangle({ray.origin, ray.direction}, corner[0],
                                                         corner[1], corner[2])
                                        : Crossing{};
        if (crossing.kind != Crossing::transversal || crossing.t < 0 || crossing.t > ray.t_max)
            hits[i] = {};
    }
};

/// Per ray: R1. Reads rays and hits; lists those whose vertex is inside its target, the candidates,
/// and writes how they leave the target. Walks and looks have met their triangle already; contacts
/// that are kept are not looked at.
struct TestInside {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const Hit> hits;
    View<const Route> routes;  ///< empty if steps do not remember
    View<Meeting> meetings;    ///< written where inside

    PIERCE_HD bool find(std::uint32_t i) const {
        if (routes.size > 0 && routes[i] == Route::kept) return false;
        if (hits[i].triangle == no_triangle || hits[i].predicted) return false;
        if (routes.size > 0 && routes[i] == Route::looked) return true;
        if (routes.size == 0 || routes[i] != Route::walked)
            meetings[i] = meet(rays[i], bodies[rays[i].target].surface(), hits[i].triangle);
        // A ray into a sheet is one of its own, and needs no inside. One into the ray's own solid
        // starts inside; it may enter other parts first (self_overlap).
        const bool is_own = rays[i].excluded[0] != no_vertex;
        return rules::starts_inside(meetings[i]) || is_own;
    }
    PIERCE_HD static std::uint32_t count(bool inside) { return inside; }
    PIERCE_HD void write(std::uint32_t i, bool inside, std::uint32_t place,
                         std::uint32_t* candidates) const {
        if (inside) candidates[place] = i;
    }
};

/// True if a ray from `vertex` meets no triangle of its own body within `depth`, apart from those
/// around the vertex: the others are further away than that in the rest shape, and no point has
/// moved from it by more than the deviation.
PIERCE_HD inline bool is_free(const BodyView& body, std::uint32_t vertex, double depth) {
    return depth + 2 * (body.deviation + body.touch) < body.mesh.star_clearance[vertex];
}

/// Per ray: R1, and of a candidate the ray into its own body, unless that body's own_exit table has
/// limited the ray already. If the triangles it starts from show that the ray starts inside (R2),
/// it need not look further than the hit (R3), and need not be traced if nothing is that near.
/// Otherwise it looks for its first crossing.
struct GenerateOwnRays {
    TestInside inside_target;
    View<const Pair> pairs;
    View<const Chord> chords;
    View<const RaySource> sources;

    PIERCE_HD bool find(std::uint32_t i) const { return inside_target.find(i); }
    PIERCE_HD static std::uint32_t count(bool inside) { return inside; }
    PIERCE_HD void write(std::uint32_t i, bool inside, std::uint32_t place,
                         std::uint32_t* candidates, Ray* own_rays,
                         std::uint32_t* starts_inside) const {
        if (!inside) return;
        candidates[place] = i;
        const Ray& into_target = inside_target.rays[i];
        const RaySource source = sources[i];
        const std::uint32_t body_index = pairs[source.pair].source(source.side);
        const BodyView& body = inside_target.bodies[body_index];
        const BodyView& target = inside_target.bodies[into_target.target];
        const bool is_vertex = source.start == RayStart::vertex;
        Ray ray;
        ray.t_max = -1.0;
        if (body.is_solid() && into_target.target != body_index &&
            (!is_vertex || body.motion == Motion::deforming)) {
            ray.origin = start_of(body, source, chords);
            ray.direction = relative_frame(target.space, body.space).rotation *
                            into_target.direction;
            ray.target = body_index;
            ray.touch = body.touch;
            const Edge edge = is_vertex ? Edge{{source.item, source.item}, {}}
                                        : body.mesh.edges[chords[source.item].edge];
            ray.excluded[0] = edge.vertex[0];
            ray.excluded[1] = edge.vertex[1];
            const bool starts = is_vertex
                                    ? leads_inside(body.mesh, body.positions, source.item,
                                                   ray.direction)
                                    : leads_inside(body.mesh, body.positions, edge, ray.direction);
            const double depth = inside_target.meetings[i].t;
            if (!starts)
                ray.t_max = body.fit_box.extent();
            else if (!is_vertex || !is_free(body, source.item, depth))
                ray.t_max = depth;
            starts_inside[place] = starts;
        }
        own_rays[place] = ray;
    }
};

/// Per candidate: R2 and R3. ray_gen has limited rays of vertices of rigid and fixed sources at
/// their own exit; open sources have no inside. A candidate whose own ray is not traced is a
/// contact. Reads own hits; writes 1 for a contact, 0 otherwise.
struct TestOwnExit {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates;
    View<const Ray> own_rays;  ///< empty if the plan traces no own exits
    View<const Hit> own_hits;
    View<const std::uint32_t> starts_inside;
    View<std::uint32_t> keep;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        keep[i] = 1;
        if (own_rays.size == 0 || own_rays[i].t_max < 0) return;
        if (own_hits[i].triangle == no_triangle) {
            keep[i] = starts_inside[i];
            return;
        }
        const std::uint32_t r = candidates[i];
        const Meeting own = meet(own_rays[i], bodies[own_rays[i].target].surface(),
                                 own_hits[i].triangle);
        keep[i] = rules::starts_in_own(own) &&
                  rules::leaves_target_first(meetings[r].t, own.t, rays[r].touch);
    }
};

}  // namespace pierce::stages
