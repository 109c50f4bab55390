#pragma once

#include "pierce/core/closest_walk.hpp"
#include "pierce/core/stages/classify.hpp"

/// After stage 9, if asked for: contacts move to the point of the target's surface that is closest nearby. An inward ray
/// leaves the target where it happens to point, which is never nearer than that. A ray towards the closest point must leave
/// the target there too, or before (R1). The way need not run through its own body: of bodies that touch in a few vertices
/// it often does not, and the contact has passed R2 and R3 along its inward ray.
namespace pierce::stages {

/// Per candidate that is a contact: walks from its triangle to the closest point, and aims a ray there. None where that is
/// no nearer, or in the surface.
struct AimAtClosest {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const RaySource> sources;
    View<const Hit> hits;
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates, keep;
    View<Ray> aimed;
    View<RaySource> aimed_sources;
    View<std::uint32_t> accepted;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t r = candidates[i];
        const BodyView& target = bodies[rays[r].target];
        accepted[i] = 0;
        aimed_sources[i] = sources[r];
        Ray& ray = aimed[i];
        ray = rays[r];
        ray.outward = 0;
        ray.t_max = -1.0;
        if (!keep[i] || sources[r].separates || !target.mesh.closed) return;
        ClosestWalk walk(target.mesh, target.positions, ray.origin, hits[r].triangle);
        const Vec3d way = walk.run(constants::reprojection_steps).point - ray.origin;
        const double depth = length(way);
        if (!(depth > target.touch) || !(depth < meetings[r].t)) return;
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
