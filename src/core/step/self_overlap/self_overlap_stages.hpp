#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/solids/classify.hpp"
#include "core/trace/closest_search.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/min_max.hpp"

/// After classify, for solids that are tested against themselves: which vertices are inside another
/// part of their own body.
///
/// An inward ray from a vertex of a solid always leaves that solid, so R1 says nothing. The winding
/// number just outside the vertex does: it is the sum of the signed crossings of the vertex's
/// outward ray, without the triangles around the vertex. If part of the solid is there, the inward
/// ray ends where that part ends (Hermann, Faure and Raffin 2008, section 5: outward to detect,
/// inward to respond). The sum is needed, because the first crossing of three overlapping parts may
/// lead in. For the same reason the inward ray leaves what it has entered on its way before it
/// ends.
namespace pierce::stages {

/// True for candidates whose ray goes into their own body.
struct IsSelfCandidate {
    View<const BodyView> bodies;
    View<const Pair> pairs;
    View<const RaySource> sources;
    View<const std::uint32_t> candidates;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        const Pair pair = pairs[sources[candidates[i]].pair];
        return pair.is_self() && bodies[pair.a].is_solid();
    }
};

/// Per such candidate: its outward ray.
struct GenerateOutwardRays {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const std::uint32_t> candidates, listed;
    View<Ray> outward;
    View<std::int32_t> winding;
    View<std::uint32_t> active;

    PIERCE_HD void operator()(std::uint32_t i) const {
        Ray ray = rays[candidates[listed[i]]];
        ray.direction = -ray.direction;
        ray.outward = 0;
        ray.t_max = bodies[ray.target].fit_box.extent() + bodies[ray.target].touch;
        outward[i] = ray;
        winding[i] = 0;
        active[i] = i;
    }
};

/// Per ray under way: counts a crossing and goes on behind it, or ends.
struct AdvanceOutward {
    View<const BodyView> bodies;
    View<const Hit> hits;
    View<const std::uint32_t> active;
    View<Ray> outward;
    View<std::int32_t> winding;
    View<std::uint32_t> goes_on;

    PIERCE_HD void operator()(std::uint32_t i) const {
        goes_on[i] = 0;
        if (hits[i].triangle == no_triangle) return;
        Ray& ray = outward[active[i]];
        const Meeting m = meet(ray, bodies[ray.target].surface(), hits[i].triangle);
        winding[active[i]] += m.exit ? 1 : -1;
        ray.t_min = max_of(m.t, ray.t_min) + ray.touch;
        goes_on[i] = ray.t_min < ray.t_max;
    }
};

/// True for such candidates whose inward ray enters another part first.
struct EntersFirst {
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates, listed;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        return !meetings[candidates[listed[i]]].exit;
    }
};

/// Per such candidate: its ray from behind that crossing on, within one part that it has entered.
struct GoOnInward {
    View<const Ray> rays;
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates, listed, active;
    View<Ray> inward;
    View<std::int32_t> entered;

    PIERCE_HD void operator()(std::uint32_t k) const {
        const std::uint32_t i = active[k], r = candidates[listed[i]];
        Ray ray = rays[r];
        ray.t_min = max_of(meetings[r].t, ray.t_min) + ray.touch;
        inward[i] = ray;
        entered[i] = 1;
    }
};

/// Per ray under way: enters or leaves another part and goes on behind it, or has come to its exit.
struct AdvanceInward {
    View<const BodyView> bodies;
    View<const Hit> found;
    View<const std::uint32_t> candidates, listed, active;
    View<Ray> inward;
    View<std::int32_t> entered;
    View<Hit> hits;
    View<Meeting> meetings;
    View<std::uint32_t> goes_on;

    PIERCE_HD void operator()(std::uint32_t k) const {
        goes_on[k] = 0;
        if (found[k].triangle == no_triangle) return;
        const std::uint32_t i = active[k], r = candidates[listed[i]];
        Ray& ray = inward[i];
        const Meeting m = meet(ray, bodies[ray.target].surface(), found[k].triangle);
        if (m.exit && entered[i] == 0) {
            hits[r] = found[k];
            meetings[r] = m;
            return;
        }
        entered[i] += m.exit ? -1 : 1;
        ray.t_min = max_of(m.t, ray.t_min) + ray.touch;
        goes_on[k] = ray.t_min < ray.t_max;
    }
};

/// Per candidate of a body against itself: 1 if its inward ray comes to an exit, and if its vertex
/// is inside another part that is not near it at rest.
struct KeepSelf {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const RaySource> sources;
    View<const Hit> hits;
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates, listed;
    View<const std::int32_t> winding;
    View<std::uint32_t> keep;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t r = candidates[listed[i]];
        const MeshView& mesh = bodies[rays[r].target].mesh;
        const Triangle& t = mesh.triangles[hits[r].triangle];
        Vec3d at_rest;
        for (int k = 0; k < 3; ++k)
            at_rest += meetings[r].barycentric[k] * to_double(mesh.positions[t.vertex[k]]);
        const double away = length(at_rest - to_double(mesh.positions[sources[r].item]));
        keep[listed[i]] = meetings[r].exit && winding[i] >= 1 &&
                          away >= constants::self_distance * mesh.mean_edge_length;
    }
};

}  // namespace pierce::stages
