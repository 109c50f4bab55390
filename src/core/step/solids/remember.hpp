#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "core/step/solids/walk.hpp"
#include "core/trace/closest_search.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/min_max.hpp"

/// remember: what the next step needs to know.
namespace pierce::stages {

/// Per full ray from a vertex: writes its record. Reads rays and hits.
struct Remember {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const Ray> rays;  ///< all
    View<const RaySource> sources;
    Temporal temporal = Temporal::paper;
    View<const Hit> hits;
    View<const Meeting> meetings;
    View<const std::uint32_t> slots;
    View<VertexRecord> records;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t slot = slots[i];
        if (sources[slot].start != RayStart::vertex) return;
        VertexRecord& record = records[slot];
        const Hit hit = hits[slot];
        record.triangle = no_triangle;
        record.predicted = 0;
        if (hit.triangle == no_triangle) return;
        const BodyView& target = bodies[rays[slot].target];
        Ray ray = rays[slot];
        if (hit.predicted) ray.direction = -ray.direction;
        const Meeting m = hit.predicted ? meet(ray, target.surface(), hit.triangle)
                                        : meetings[slot];
        if (m.exit == hit.predicted) return;
        record.triangle = record.seen_triangle = hit.triangle;
        record.predicted = hit.predicted;
        if (temporal == Temporal::paper) {
            const Triangle& t = target.mesh.triangles[hit.triangle];
            const Vec3d corner[3] = {to_double(target.positions[t.vertex[0]]),
                                     to_double(target.positions[t.vertex[1]]),
                                     to_double(target.positions[t.vertex[2]])};
            const RaySource from = sources[slot];
            record.expiry = hit.predicted ? wait_until(directed[2 * from.pair + from.side],
                                                       height_over(corner, ray.direction, m.t))
                                          : 0.0f;
        }
        for (int k = 0; k < 2; ++k) record.seen_weight[k] = static_cast<float>(m.barycentric[k]);
        const Matrix3 to_fit = (target.motion == Motion::deforming ? target.fit.rotation
                                                                   : Matrix3{})
                                   .transposed();
        record.seen_offset = to_float(m.t * (to_fit * ray.direction));
    }
};

/// True for full rays whose vertex is worth a proof that it is outside: the ray met nothing, and
/// the last attempt was long ago.
struct IsUncertain {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const Ray> rays;
    View<const RaySource> sources;
    View<const Hit> hits;
    View<const std::uint32_t> slots;
    View<const VertexRecord> records;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        const std::uint32_t slot = slots[i];
        const RaySource from = sources[slot];
        const DirectedPair& d = directed[2 * from.pair + from.side];
        return from.start == RayStart::vertex &&
               (hits[slot].triangle == no_triangle || hits[slot].predicted) &&
               rays[slot].t_max >= 0 && proofs_pay(d, bodies[d.target]) &&
               !(records[slot].retry > d.odometer);
    }
};

/// Per uncertain vertex: its ray, as long as the target's box. If that ray meets nothing either, no
/// surface lies between the vertex and the far outside. Rays that only tell whether they start
/// inside are that long already.
struct ProlongRay {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const std::uint32_t> slots, uncertain;  ///< uncertain: places in slots
    View<Ray> prolonged;

    PIERCE_HD void operator()(std::uint32_t i) const {
        Ray ray = rays[slots[uncertain[i]]];
        ray.t_max = range_through(bodies[ray.target], ray.origin);
        ray.outward = 0;
        prolonged[i] = ray;
    }
};

/// Per uncertain vertex: how near its target has to be to matter. If the prolonged ray has met
/// something, there is no proof and nothing to look for.
struct LimitToCertificate {
    View<const BodyView> bodies;
    View<const Hit> hits;  ///< empty if no ray was to be prolonged
    View<Ray> prolonged;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const double limit = constants::certificate_limit *
                             bodies[prolonged[i].target].mesh.mean_edge_length;
        prolonged[i].t_max = hits.size == 0 || hits[i].triangle == no_triangle ? limit : -1.0;
        prolonged[i].excluded[0] = prolonged[i].excluded[1] = no_triangle;
    }
};

/// Per uncertain vertex: the odometer up to which it needs no ray, and 1 if it is proved to be
/// outside. Before it needs a ray, it may move by its distance to the surface.
struct Certify {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const RaySource> sources;
    View<const std::uint32_t> slots, uncertain;
    View<const Ray> limited;
    View<const std::uint32_t> closest;  ///< triangles of the target, within the limit
    View<VertexRecord> records;

    PIERCE_HD std::uint32_t operator()(std::uint32_t i) const {
        const std::uint32_t slot = slots[uncertain[i]];
        const BodyView& target = bodies[limited[i].target];
        const RaySource from = sources[slot];
        const DirectedPair& d = directed[2 * from.pair + from.side];
        VertexRecord& record = records[slot];
        const Ray& ray = limited[i];
        const double distance = closest[i] == no_triangle
                                    ? ray.t_max
                                    : distance_to(ray.origin, target.surface(), closest[i]);
        const double free = max_of(distance - 2 * target.touch, 0.0);
        record.expiry = d.odometer + static_cast<float>(free);
        // A proof costs as much as a few rays: one that would hold for less is not worth it.
        record.retry = d.odometer +
                       max_of(static_cast<float>(free),
                              static_cast<float>(constants::certificate_steps) * d.step);
        return free > 0;
    }
};

}  // namespace pierce::stages
