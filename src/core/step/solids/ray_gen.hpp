#pragma once

#include "core/body/body_view.hpp"
#include "core/device/rarely.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/mesh/edge_normal.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/look.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/min_max.hpp"

/// ray_gen: one ray per vertex left, along its inward normal.
namespace pierce::stages {

/// The unit inward direction at a vertex, in the body's space; zero where there is none.
PIERCE_HD inline Vec3d inward_direction(const BodyView& body, std::uint32_t vertex) {
    const Vec3d n = body.motion == Motion::deforming
                        ? vertex_normal(body.mesh, body.positions, vertex)
                        : normalized(to_double(body.mesh.normals[vertex]));
    return -n;
}

/// The unit inward direction at an edge, in the body's space; zero where there is none.
PIERCE_HD inline Vec3d inward_direction(const BodyView& body, const Edge& edge) {
    return -edge_normal(body.mesh, body.positions, edge);
}

/// True if a vertex's inward ray runs in its own body, by more than rounding: otherwise what it
/// finds inside a target says nothing about what the two have in common.
PIERCE_RARELY PIERCE_HD inline bool runs_in_own(const BodyView& source, std::uint32_t vertex) {
    return leads_well_inside(source.mesh, source.positions, vertex,
                             inward_direction(source, vertex));
}

/// True if the inward ray of a vertex that touches, which leaves the target at `t`, shows that the
/// two bodies overlap there, and not only that rounding moved one of them.
PIERCE_HD inline bool runs_through_both(const BodyView& source, std::uint32_t vertex, double t,
                                        double touch) {
    return t > constants::skin * touch && runs_in_own(source, vertex);
}

/// The point of an edge between its first vertex (0) and its second (1), in the body's space.
PIERCE_HD inline Vec3d point_on(const BodyView& body, const Edge& edge, double along) {
    const Vec3d a = to_double(body.positions[edge.vertex[0]]),
                b = to_double(body.positions[edge.vertex[1]]);
    return (1 - along) * a + along * b;
}

/// Where a ray starts, in its source's space.
PIERCE_HD inline Vec3d start_of(const BodyView& source, const RaySource& from,
                                View<const Chord> chords) {
    if (from.start == RayStart::vertex) return to_double(source.positions[from.item]);
    const Chord& chord = chords[from.item];
    return point_on(source, source.mesh.edges[chord.edge], chord.along);
}

/// The unit direction of a ray that only tells whether its origin is inside.
PIERCE_HD inline Vec3d any_direction() {
    return normalized(Vec3d{constants::any_direction[0], constants::any_direction[1],
                            constants::any_direction[2]});
}

/// How far a ray that starts in a body can get inside that body's box. Origin and direction in the
/// body's space.
PIERCE_HD inline double box_range(const BodyView& body, Vec3d origin, Vec3d direction) {
    const bool deforms = body.motion == Motion::deforming;  // the space of other bodies is their
                                                            // fit frame
    const Vec3d o = deforms ? body.fit.to_local(origin) : origin;
    const Vec3d d = deforms ? body.fit.rotation.transposed() * direction : direction;
    double range = body.fit_box.extent();
    for (int i = 0; i < 3; ++i)
        if (d[i] != 0)
            range = min_of(
                ((d[i] > 0 ? body.fit_box.upper[i] : body.fit_box.lower[i]) - o[i]) / d[i], range);
    return max_of(range, 0.0) + body.touch;
}

/// How far a ray may go before it has left its own body's box or the target's: a later stage looks
/// for its own exit.
PIERCE_HD inline double range_in_boxes(const BodyView& source, const BodyView& target, Vec3d origin,
                                       Vec3d direction) {
    return min_of(target.fit_box.extent(), box_range(source, origin, direction));
}

/// How far a ray has to go to be outside of the target for certain. Its origin in the target's
/// space.
PIERCE_HD inline double range_through(const BodyView& target, Vec3d origin) {
    const Vec3d in_fit = target.motion == Motion::deforming ? target.fit.to_local(origin) : origin;
    return target.fit_box.extent() + target.fit_box.distance(in_fit) + target.touch;
}

/// How far an inward ray from `vertex` may go before it leaves its own body for certain.
PIERCE_HD inline double inward_range(const BodyView& source, const BodyView& target,
                                     std::uint32_t vertex, Vec3d direction) {
    if (!source.mesh.closed) return source.range;
    if (source.motion != Motion::deforming) return source.mesh.own_exit[vertex];
    return range_in_boxes(source, target, to_double(source.positions[vertex]), direction);
}

/// A ray of a sheet's vertex along the way it has come in this step, or against it, into the sheet
/// itself (the paper, section 5.2). The ray is as long as that way, and longer where the layer that
/// is hit may come towards it.
PIERCE_HD inline Ray velocity_ray(const BodyView& body, const DirectedPair& d, bool against,
                                  std::uint32_t v) {
    Ray ray;
    ray.origin = to_double(body.positions[v]);
    const Vec3d way = ray.origin - to_double(body.start[v]);
    ray.direction = normalized(against ? -way : way);
    const double more = body.collision.self == SelfCollision::rays ? body.travel : 0.0;
    ray.t_max = length_squared(way) > 0 ? length(way) + more : -1.0;
    ray.target = d.target;
    ray.touch = d.touch;
    ray.excluded[0] = ray.excluded[1] = v;
    return ray;
}

/// The inward ray of a vertex into the other body of its pair. If the vertex has no direction, the
/// ray hits nothing; but where the ray only tells whether the vertex is inside (`only_inside`), any
/// direction does. A vertex without triangles is no part of the surface.
PIERCE_HD inline void aim_vertex_ray(View<const BodyView> bodies, const DirectedPair& d,
                                     std::uint32_t v, bool only_inside, Ray& ray) {
    const BodyView& source = bodies[d.source];
    const BodyView& target = bodies[d.target];
    const Vec3d inward = inward_direction(source, v);
    const bool has_direction = length_squared(inward) > 0,
               through = !d.is_self() && (only_inside || source.collision.sheet),
               has_way = has_direction || (through && has_triangles(source.mesh, v));
    const Vec3d direction = has_direction || !has_way ? inward : any_direction();
    ray = {};
    ray.origin = d.to_space.to_parent(to_double(source.positions[v]));
    ray.direction = d.to_space.rotation * direction;
    if (!has_way)
        ray.t_max = -1.0;
    else
        ray.t_max = through ? range_through(target, ray.origin)
                            : inward_range(source, target, v, direction);
    ray.target = d.target;
    ray.touch = d.touch;
    if (d.is_self()) {
        ray.excluded[0] = ray.excluded[1] = v;
        // At rest only the triangles around the vertex come so close, and nothing has moved so far
        // since.
        if (source.mesh.star_clearance[v] > 2 * (source.deviation + source.touch)) ray.t_max = -1.0;
    }
}

/// Moves a record's material point to where it is now and returns how far the vertex has moved
/// relative to it, in the target's fit frame.
PIERCE_HD inline double displacement(const VertexRecord& record, const BodyView& target,
                                     Vec3d origin) {
    const Triangle& t = target.mesh.triangles[record.seen_triangle];
    const double u = static_cast<double>(record.seen_weight[0]),
                 v = static_cast<double>(record.seen_weight[1]);
    const Vec3d now = u * to_double(target.positions[t.vertex[0]]) +
                      v * to_double(target.positions[t.vertex[1]]) +
                      (1 - u - v) * to_double(target.positions[t.vertex[2]]);
    const Matrix3 to_fit = (target.motion == Motion::deforming ? target.fit.rotation : Matrix3{})
                               .transposed();
    return length(to_fit * (now - origin) - to_double(record.seen_offset));
}

/// Per vertex left: its ray and, if steps remember, what becomes of it: a look or a walk from its
/// record, or a full ray. A look that finds the vertex inside writes the way to the closest point
/// as its ray, and where that ends; one that finds it outside notes for how long.
struct GenerateRay {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const RaySource> sources;
    Settings settings;
    View<VertexRecord> records;
    View<Ray> rays;
    View<Hit> hits;
    View<Meeting> meetings;
    View<Route> routes;  ///< empty if steps do not remember

    PIERCE_HD void operator()(std::uint32_t i) const {
        hits[i] = {};
        if (routes.size > 0 && routes[i] == Route::skip) return;  // no stage reads the ray
        const DirectedPair& d = directed[2 * sources[i].pair + sources[i].side];
        if (d.still) {
            if (!records[i].predicted) hits[i].triangle = records[i].triangle;
            return;  // no stage reads the ray
        }
        if (d.along_velocity) {
            rays[i] = velocity_ray(bodies[d.source], d, sources[i].side == 1, sources[i].item);
            return;
        }
        if (settings.looks() && look(i, d)) return;
        write_side_by_side(rays.data, i, [&](Ray& ray) { aim(i, d, ray); });
    }

private:
    PIERCE_HD void aim(std::uint32_t i, const DirectedPair& d, Ray& ray) const {
        aim_vertex_ray(bodies, d, sources[i].item, settings.inside_is_contact(), ray);
        if (routes.size > 0) routes[i] = route(d, ray, records[i]);
        if (settings.temporal == Temporal::paper && settings.predict && routes[i] == Route::full)
            ray.outward = d.approach.reach(to_double(bodies[d.source].positions[sources[i].item]),
                                           0, bodies[d.source].shape_motion);
        if (settings.temporal == Temporal::certified) ray.outward = search_range(d, records[i]);
    }

    /// True if a look from the vertex's record tells whether it is inside.
    PIERCE_HD bool look(std::uint32_t i, const DirectedPair& d) const {
        const BodyView& target = bodies[d.target];
        VertexRecord& record = records[i];
        if (record.triangle == no_triangle || d.is_self() || !target.is_simple()) return false;
        const Vec3d point = d.to_space.to_parent(
            to_double(bodies[d.source].positions[sources[i].item]));
        const Look look(target, record.triangle, point, d.touch);
        if (look.seen == Look::outside) {
            routes[i] = Route::skip;
            record.expiry = d.odometer + static_cast<float>(look.free);
        } else if (look.seen == Look::inside) {
            routes[i] = Route::looked;
            Ray ray;
            ray.origin = point;
            ray.direction = normalized(look.closest - point);
            ray.t_max = look.depth;
            ray.target = d.target;
            ray.touch = d.touch;
            rays[i] = ray;
            hits[i] = {record.triangle};
            meetings[i] = meeting_at(look.closest, look.depth, look.corner[0], look.corner[1],
                                     look.corner[2]);
        }
        return look.seen != Look::nothing;
    }

    /// How far to look outward for a triangle to walk on from.
    PIERCE_HD double search_range(const DirectedPair& d, const VertexRecord& record) const {
        const BodyView& target = bodies[d.target];
        return proofs_pay(d, target) && !(record.retry > d.odometer)
                   ? constants::certificate_limit * target.mesh.mean_edge_length
                   : 0;
    }

    PIERCE_HD Route route(const DirectedPair& d, const Ray& ray, const VertexRecord& record) const {
        const BodyView& target = bodies[d.target];
        if (!(ray.t_max >= 0)) return Route::skip;
        if (record.triangle == no_triangle || d.is_self()) return Route::full;
        // A walk is of use only if it can be certified. It cannot where the target has changed its
        // shape too much.
        if (settings.temporal == Temporal::certified)
            return 2 * target.deviation <
                           static_cast<double>(target.mesh.rings[record.triangle].gap)
                       ? Route::walk
                       : Route::full;
        if (d.pass == Pass::full) return Route::full;
        const bool deforms = target.motion == Motion::deforming ||
                             bodies[d.source].motion == Motion::deforming;
        if (!deforms) return Route::walk;
        const double far = settings.walk_threshold * target.mesh.mean_edge_length;
        return displacement(record, target, ray.origin) > far ? Route::full : Route::walk;
    }
};

}  // namespace pierce::stages
