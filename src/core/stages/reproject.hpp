#pragma once

#include "pierce/core/closest_search.hpp"
#include "pierce/core/stages/classify.hpp"

/// After stage 9, if asked for: contacts move to the closest point of the target's surface. An inward ray leaves the target
/// where it happens to point, which is never nearer than that. A ray towards the closest point must leave the target there
/// too, or before (R1). The way need not run through its own body: of bodies that touch in a few vertices it often does not,
/// and the contact has passed R2 and R3 along its inward ray.
namespace pierce::stages {

/// Per candidate: where to look for a closer point, if it is a contact that may move, and no further than the contact is
/// deep.
struct LimitToDepth {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const RaySource> sources;
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates, keep;
    View<Ray> limited;
    View<RaySource> limited_sources;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t r = candidates[i];
        const bool may_move = keep[i] && !sources[r].separates && bodies[rays[r].target].mesh.closed;
        limited_sources[i] = sources[r];
        limited[i] = rays[r];
        limited[i].outward = 0;
        limited[i].t_max = may_move ? meetings[r].t : -1.0;
    }
};

/// Per limited ray: aims it at the closest point, unless that is no nearer than the contact, or in the surface.
struct AimAtClosest {
    View<const BodyView> bodies;
    View<const std::uint32_t> closest;  ///< triangles of the target, within the limit
    View<Ray> rays;
    View<std::uint32_t> accepted;

    PIERCE_HD void operator()(std::uint32_t i) const {
        Ray& ray = rays[i];
        const BodyView& target = bodies[ray.target];
        const double limit = ray.t_max;
        accepted[i] = 0;
        ray.t_max = -1.0;
        if (closest[i] == no_triangle) return;
        const Vec3d way = closest_point(ray.origin, target.surface(), closest[i]) - ray.origin;
        const double depth = length(way);
        if (!(depth > target.touch) || !(depth < limit)) return;
        ray.direction = normalized(way);
        ray.t_max = depth + target.touch;
    }
};

/// Per aimed candidate whose ray leaves the target: accepts it.
struct AcceptAimed {
    View<const Meeting> meetings, aimed_meetings;
    View<const std::uint32_t> main_candidates, candidates;  ///< candidates: of the aimed rays
    View<std::uint32_t> accepted;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t c = candidates[i];
        accepted[c] = aimed_meetings[c].t < meetings[main_candidates[c]].t;
    }
};

}  // namespace pierce::stages
