#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/solids/classify.hpp"
#include "core/trace/closest_search.hpp"
#include "core/trace/meeting.hpp"

/// After classify, if asked for: contacts move to the closest point of the target's surface. The
/// place where an inward ray leaves the target is never nearer than the closest point. No point of
/// the surface is nearer than the closest point, so the way there is inside the target (R1). The
/// way need not run through the vertex's own body. For bodies that touch in a few vertices it often
/// does not, and the contact has passed R2 and R3 along its inward ray.
namespace pierce::stages {

/// Per candidate: where to look for a closer point, if it is a contact that may move, and no
/// further than the contact is deep.
struct LimitToDepth {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const RaySource> sources;
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates, keep;
    View<Ray> limited;
    View<const Pair> pairs;
    bool all = true;  ///< if false, only contacts of sheets, whose normals say nothing about the
                      ///< way out of another body

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t r = candidates[i];
        const Pair pair = pairs[sources[r].pair];
        const bool may_move = keep[i] && !sources[r].separates && !pair.is_self() &&
                              bodies[rays[r].target].is_solid() &&
                              (all || bodies[pair.source(sources[r].side)].collision.sheet);
        limited[i] = rays[r];
        limited[i].outward = 0;
        limited[i].t_max = may_move ? meetings[r].t : -1.0;
    }
};

/// Per limited ray: moves its end to the closest point, unless that is no nearer than the contact,
/// or in the surface.
struct MoveToClosest {
    View<const BodyView> bodies;
    View<const std::uint32_t> closest;  ///< triangles of the target, within the limit
    View<Ray> rays;
    View<Hit> hits;
    View<Meeting> meetings;
    View<std::uint32_t> accepted;

    PIERCE_HD void operator()(std::uint32_t i) const {
        accepted[i] = 0;
        if (closest[i] == no_triangle) return;
        Ray& ray = rays[i];
        const Surface surface = bodies[ray.target].surface();
        const Triangle& t = surface.triangles[closest[i]];
        const Vec3d a = to_double(surface.positions[t.vertex[0]]),
                    b = to_double(surface.positions[t.vertex[1]]),
                    c = to_double(surface.positions[t.vertex[2]]);
        const Vec3d point = closest_point(ray.origin, surface, closest[i]),
                    way = point - ray.origin;
        const double depth = length(way);
        if (!(depth > ray.touch) || !(depth < ray.t_max) || is_degenerate(a, b, c)) return;
        ray.direction = normalized(way);
        hits[i] = {closest[i]};
        meetings[i] = meeting_at(point, depth, a, b, c);
        accepted[i] = 1;
    }
};

}  // namespace pierce::stages
