#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/step/common/count.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/surface_walk.hpp"
#include "pierce/contact.hpp"
#include "pierce/min_max.hpp"

/// walk: answers from last step's triangle; a lost walk becomes a full ray of the same
/// step.
namespace pierce::stages {

/// True for rays of a route.
struct HasRoute {
    View<const Route> routes;
    Route wanted = Route::full;

    PIERCE_HD bool operator()(std::uint32_t i) const { return routes[i] == wanted; }
};

/// How far the origin of a ray that crosses a triangle at `t` is from the triangle's plane.
PIERCE_HD inline double height_over(const Vec3d corner[3], Vec3d direction, double t) {
    return std::fabs(
        t * dot(normalized(cross(corner[1] - corner[0], corner[2] - corner[0])), direction));
}

/// The odometer up to which a vertex at a height over a triangle's plane is left alone, at a small
/// risk.
PIERCE_HD inline float wait_until(const DirectedPair& d, double height) {
    return d.odometer + static_cast<float>(constants::prediction_wait * height);
}

/// Per walk: goes on from the record. In certified mode the result counts only if it is proved to
/// be what a full ray would find; in the paper's mode, any exit ahead counts, and an exit behind
/// stays a prediction. Reads rays and routes; writes hits, routes and records.
struct Walk {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const Ray> rays;
    View<const RaySource> sources;
    View<const std::uint32_t> slots;
    Temporal temporal = Temporal::paper;
    View<Hit> hits;
    View<Route> routes;
    View<VertexRecord> records;
    View<Found> found;  ///< per ray
    View<Meeting> meetings;
    View<WalkCount> counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t slot = slots[i];
        const Ray& ray = rays[slot];
        const BodyView& target = bodies[ray.target];
        VertexRecord& record = records[slot];
        const ShearedRay line(ray.origin, ray.direction);
        found[slot] = Found::walk;
        counts[i] = {0, true};
        routes[slot] = Route::full;
        std::uint32_t at = record.triangle;
        Vec3d corner[3];
        Crossing crossing = cross(target, line, at, corner);
        if (crossing.kind == Crossing::none) {
            const WalkEnd end = walk(target.mesh, target.positions, line, at,
                                     constants::walk_steps);
            counts[i].steps = end.steps;
            if (end.kind != WalkEnd::found) return;
            at = end.triangle;
            crossing = cross(target, line, at, corner);
        }
        if (temporal == Temporal::certified) {
            const Vec3d in_fit = target.motion == Motion::deforming
                                     ? target.fit.rotation.transposed() * ray.direction
                                     : ray.direction;
            if (!is_only_crossing(target.mesh.rings[at], crossing, in_fit, target.deviation,
                                  ray.touch))
                return;
            // If a simple target's only surface nearby is behind the origin, the origin is outside:
            // no contact. If the crossing is just beyond the ray's end, a tracer decides.
            const bool behind = crossing.t < -ray.touch;
            if (behind && !target.is_simple()) return;
            if (crossing.t > ray.t_max && !(crossing.t > ray.t_max + ray.touch)) return;
            if (!behind && crossing.t <= ray.t_max) hits[slot].triangle = at;
            if (behind) {
                const double free = distance_in_front(
                    target.mesh.rings[at], crossing,
                    height_over(corner, ray.direction, crossing.t));
                const DirectedPair& d = directed[2 * sources[slot].pair + sources[slot].side];
                record.expiry = d.odometer + static_cast<float>(max_of(
                                                 free - 2 * (ray.touch + target.deviation), 0.0));
            }
        } else {
            if (crossing.kind != Crossing::transversal || !(crossing.sign > 0)) return;
            const bool ahead = crossing.t >= -ray.touch;
            const RaySource from = sources[slot];
            const DirectedPair& d = directed[2 * from.pair + from.side];
            if (!ahead && !(d.approach.most > 0)) return;
            if (crossing.t < -(d.approach.most + ray.touch)) {
                // The vertex is too far away to enter before the next full pass, which looks at all
                // vertices.
                routes[slot] = Route::skip;
                record.triangle = no_triangle;
                counts[i].lost = false;
                return;
            }
            if (record.predicted) found[slot] = Found::prediction;
            record.predicted = !ahead;
            record.expiry = ahead ? 0
                                  : wait_until(d, height_over(corner, ray.direction, crossing.t));
            if (ahead && crossing.t <= ray.t_max + ray.touch) hits[slot].triangle = at;
        }
        counts[i].lost = false;
        routes[slot] = Route::walked;
        record.triangle = at;
        meetings[slot] = meeting_of(crossing, ray, corner[0], corner[1], corner[2]);
    }

private:
    PIERCE_HD static Crossing cross(const BodyView& body, const ShearedRay& line,
                                    std::uint32_t triangle, Vec3d corner[3]) {
        const Triangle& t = body.mesh.triangles[triangle];
        for (int k = 0; k < 3; ++k) corner[k] = to_double(body.positions[t.vertex[k]]);
        return cross_triangle(line, corner[0], corner[1], corner[2]);
    }
};

}  // namespace pierce::stages
