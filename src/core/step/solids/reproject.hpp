#pragma once

#include "core/body/body_view.hpp"
#include "core/device/number.hpp"
#include "core/device/view.hpp"
#include "core/device/warp.hpp"
#include "core/device/whole.hpp"
#include "core/geometry/closest_points_of_segments.hpp"
#include "core/mesh/edge_normal.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/look.hpp"
#include "core/step/solids/mark_candidate.hpp"
#include "core/trace/closest_search.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/surface_walk.hpp"

/// After classify, if asked for: contacts move to the closest point of the target's surface. The
/// place where an inward ray leaves the target is never nearer than the closest point. No point of
/// the surface is nearer than the closest point, so the way there is inside the target (R1). The
/// way need not run through the vertex's own body. For bodies that touch in a few vertices it often
/// does not, and the contact has passed R2 and R3 along its inward ray. A contact whose closest
/// point is within the touch tolerance touches: it has no depth, however far its ray went, and the
/// normal of the surface there.
///
/// Where parts of the target overlap and the closest triangle is covered partly, the contact stays
/// where its ray ends, unless it touches.
///
/// A chord over a ridge ends on the ridge instead: to leave the target, its edge has to pass that
/// ridge, which is further away than the faces beside it. Unless another face is so near that the
/// whole chord leaves through it on a shorter way: then it ends there.
namespace pierce::stages {

/// The ridge that a ray's chord is over, if there is one.
PIERCE_HD inline Ridge ridge_below(const RaySource& from, View<const Chord> chords) {
    return from.start == RayStart::chord ? chords[from.item].ridge : Ridge{};
}

/// The point of a ridge that is closest to a point.
PIERCE_HD inline Vec3d closest_on(const RidgeEnds& ridge, Vec3d point) {
    const Vec3d along = ridge.to - ridge.from;
    return ridge.from + closest_place_on_segment(point, ridge.from, along) * along;
}

/// Per candidate from `begin` on: where to look for a closer point, if it is a contact that may
/// move, and no further than the contact is deep. Nothing is to be looked for if the triangle that
/// the ray hit is certainly the closest one, or a look has found the closest point already.
struct LimitToDepth {
    View<const BodyView> bodies;
    View<const Ray> rays;
    View<const RaySource> sources;
    View<const Hit> hits;
    View<const Meeting> meetings;
    View<const Route> routes;  ///< empty if steps do not remember
    View<const std::uint32_t> candidates, keep;
    Number begin;
    View<Ray> limited;          ///< per candidate from `begin` on, like the next one
    View<std::uint32_t> known;  ///< the closest triangle, if it is known
    View<const Pair> pairs;
    View<const Chord> chords;
    bool all = true;  ///< if false, only contacts of sheets, whose normals say nothing about the
                      ///< way out of another body

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t candidate = begin + i, r = candidates[candidate];
        if (routes.size > 0 && routes[r] == Route::looked) {
            known[i] = no_triangle;
            limited[i].target = rays[r].target;
            limited[i].t_max = -1.0;
            return;
        }
        const Pair pair = pairs[sources[r].pair];
        const bool may_move = keep[candidate] && !sources[r].separates && !pair.is_self() &&
                              bodies[rays[r].target].is_solid() &&
                              (all || bodies[pair.source(sources[r].side)].collision.sheet);
        write_side_by_side(limited.data, i, [&](Ray& ray) {
            ray = read_whole(rays[r]);
            ray.outward = 0;
            ray.excluded[0] = ray.excluded[1] = no_triangle;
            known[i] = no_triangle;
            if (may_move)
                limit(r, ray, known[i]);
            else
                ray.t_max = -1.0;
        });
    }

private:
    PIERCE_HD void limit(std::uint32_t r, Ray& ray, std::uint32_t& closest) const {
        const Ridge ridge = ridge_below(sources[r], chords);
        const BodyView& target = bodies[ray.target];
        if (ridge.exists()) {
            // Only what is nearer than the ridge can be a shorter way, and the faces beside the
            // ridge are none.
            closest = ridge.triangle;
            ray.excluded[0] = ridge.triangle;
            ray.excluded[1] = target.mesh.neighbors[ridge.triangle].across[ridge.corner];
            ray.t_max = length(closest_on(RidgeEnds(target.surface(), ridge), ray.origin) -
                               ray.origin);
        } else if (!(meetings[r].t > 0) || is_closest(target, ray.origin, hits[r].triangle)) {
            closest = hits[r].triangle;
            ray.t_max = -1.0;
        } else {
            ray.t_max = meetings[r].t;
        }
    }

    PIERCE_HD static bool is_closest(const BodyView& target, Vec3d point, std::uint32_t triangle) {
        const TriangleCorners at = target.surface().corners(triangle);
        return OverTriangle(point, at.a, at.b, at.c).is_closest(target, triangle);
    }
};

/// Per candidate from `begin` on: moves the ray's end to the ridge that its chord is over, or to
/// the closest point, unless a search has found none that is nearer than the contact.
struct MoveToClosest {
    View<const BodyView> bodies;
    View<const Ray> limited;            ///< per candidate from `begin` on, like the next two
    View<const std::uint32_t> known;    ///< triangles of the target
    View<const std::uint32_t> closest;  ///< where none is known: within the limit
    View<const RaySource> sources;
    View<const Chord> chords;
    View<const std::uint32_t> candidates;
    View<const Meeting> found;  ///< per ray
    Number begin;
    View<Ray> rays;  ///< per candidate, like the others; of those that do not move, it means
                     ///< nothing
    View<Hit> hits;
    View<Meeting> meetings;
    View<std::uint32_t> accepted;
    ContainedBodies contained;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t candidate = begin + i, r = candidates[candidate];
        write_side_by_side(rays.data, candidate, [&](Ray& ray) {
            ray = read_whole(limited[i]);
            accepted[candidate] = moves(i, candidate, found[r].t, ray);
        });
        contained.note(sources[r], (accepted[candidate] ? meetings[candidate] : found[r]).t > 0);
    }

private:
    /// True if a chord over a ridge, which is `far` from it, leaves the target as a whole on a
    /// shorter way, towards its closest point on a triangle. Where that way leads into the faces
    /// beside the ridge, the rest of its edge may get in: then it has to be much shorter.
    PIERCE_HD static bool leaves_sooner(const Chord& chord, Vec3d point, double far,
                                        const BodyView& target, std::uint32_t triangle) {
        if (triangle == no_triangle) return false;
        const Surface surface = target.surface();
        if (surface.covered.size > 0 && surface.covered[triangle] != Cover::none) return false;
        const Vec3d to = closest_point(point, surface, triangle), way = to - point;
        const double size = length(way);
        if (!(size > 0)) return false;
        const Vec3d direction = (1 / size) * way;
        const std::uint32_t beside = chord.ridge.triangle,
                            other = target.mesh.neighbors[beside].across[chord.ridge.corner];
        const bool leads_in = leads_into(way, surface, beside) ||
                              (other != no_triangle && leads_into(way, surface, other));
        return max_of(dot(to - chord.begin, direction), dot(to - chord.end, direction)) <
               (leads_in ? constants::ridge_share * far : far);
    }

    /// Turns the ray to where the contact ends now, if it moves.
    PIERCE_HD bool moves(std::uint32_t i, std::uint32_t candidate, double depth_of_ray,
                         Ray& ray) const {
        const bool is_known = known[i] != no_triangle;
        std::uint32_t triangle = is_known ? known[i] : closest[i];
        if (triangle == no_triangle) return false;
        const Surface surface = bodies[ray.target].surface();
        const RaySource& from = sources[candidates[candidate]];
        Ridge ridge = ridge_below(from, chords);
        if (ridge.exists() && leaves_sooner(chords[from.item], ray.origin, ray.t_max,
                                            bodies[ray.target], closest[i])) {
            triangle = closest[i];
            ridge = {};
        }
        const TriangleCorners at = surface.corners(triangle);
        const Vec3d point = ridge.exists() ? closest_on(RidgeEnds(surface, ridge), ray.origin)
                                           : closest_point(ray.origin, surface, triangle);
        const Vec3d way = point - ray.origin;
        const double depth = length(way);
        if (!(is_known || depth < depth_of_ray) || is_degenerate(at.a, at.b, at.c)) return false;
        const bool touches = !(depth > ray.touch);
        // The closest point of a triangle that is covered partly may lie in another part, but not
        // where a ray has left.
        if (depth_of_ray > 0 && surface.covered.size > 0 &&
            surface.covered[triangle] != Cover::none)
            return false;
        // Rounding decides where so short a way leads.
        ray.direction = normalized(touches ? at.normal() : way);
        hits[candidate] = {triangle};
        meetings[candidate] = meeting_at(point, touches ? 0.0 : depth, at.a, at.b, at.c);
        return true;
    }
};

}  // namespace pierce::stages
