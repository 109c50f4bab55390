#pragma once

#include "core/device/view.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/trace/ray.hpp"
#include "pierce/mesh.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// How a walk over a surface ended.
struct WalkEnd {
    enum Kind : std::uint8_t {
        found,       ///< the line passes through `triangle`
        silhouette,  ///< the surface turned away twice
        boundary,    ///< there is no triangle, or more than one, across the edge
        edge_on,     ///< the line lies in the triangle's plane
        step_limit,
    };
    Kind kind = step_limit;
    std::uint32_t triangle = no_triangle;
    std::uint32_t steps = 0;  ///< from triangle to triangle
};

/// Walks from triangle `start` to one that the line meets. Each time it crosses the edge that has
/// the line furthest on its outer side (Lehericey, Gouranton and Arnaldi 2013). The walk may find a
/// crossing that is not the first, or none.
PIERCE_HD inline WalkEnd walk(const MeshView& mesh, View<const Vec3f> positions,
                              const ShearedRay& line, std::uint32_t start,
                              std::uint32_t max_steps) {
    std::uint32_t at = start, from = no_triangle;
    double side = 0;
    std::uint32_t turns = 0;
    for (std::uint32_t step = 0;; ++step) {
        const Triangle& t = mesh.triangles[at];
        const Vec3d p = line.sheared(to_double(positions[t.vertex[0]]) - line.origin);
        const Vec3d q = line.sheared(to_double(positions[t.vertex[1]]) - line.origin);
        const Vec3d r = line.sheared(to_double(positions[t.vertex[2]]) - line.origin);
        // Twice the areas the line's point spans with the edges; all have one sign if the point
        // lies inside.
        const double area[3] = {r.x * q.y - r.y * q.x, p.x * r.y - p.y * r.x,
                                q.x * p.y - q.y * p.x};
        const double all = area[0] + area[1] + area[2];
        if (all == 0) return {WalkEnd::edge_on, at, step};
        const double sign = all > 0 ? 1.0 : -1.0;
        if (side != 0 && sign != side && ++turns > 1) return {WalkEnd::silhouette, at, step};
        side = sign;
        if (sign * area[0] >= 0 && sign * area[1] >= 0 && sign * area[2] >= 0)
            return {WalkEnd::found, at, step};
        if (step == max_steps) return {WalkEnd::step_limit, at, step};

        const Vec3d edge[3] = {r - q, p - r, q - p};
        std::uint32_t next = no_triangle;
        double worst = 0;
        bool any = false;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t across = mesh.neighbors[at].across[k];
            if (sign * area[k] >= 0 || (across == from && across != no_triangle)) continue;
            const double distance = sign * area[k] /
                                    std::sqrt(edge[k].x * edge[k].x + edge[k].y * edge[k].y);
            if (any && !(distance < worst)) continue;
            any = true;
            worst = distance;
            next = across;
        }
        if (!any) return {WalkEnd::silhouette, at, step};
        if (next == no_triangle) return {WalkEnd::boundary, at, step};
        from = at;
        at = next;
    }
}

/// A lower bound of how far the triangle's point with these barycentrics is from the other
/// triangles of the ring.
PIERCE_HD inline double ring_distance(const TriangleRing& ring, const double (&weight)[3]) {
    double border = weight[0] * static_cast<double>(ring.height[0]);
    for (int k = 1; k < 3; ++k)
        border = min_of(weight[k] * static_cast<double>(ring.height[k]), border);
    return static_cast<double>(ring.openness) * border;
}

/// True if `crossing`, of a ray with a triangle, leads out of the surface and is certainly the only
/// crossing between the ray's origin and the triangle. A tracer would then return this triangle if
/// it lies ahead. `ring` is the triangle's ring in the rest shape, `direction` the ray's direction
/// as the rest shape sees it. No vertex is further than `deviation` from its place in the rest
/// shape.
///
/// Proof. Let Q be the point met and t its distance, ahead or behind. Everything that the ray
/// crosses between a touch tolerance behind its origin and a touch tolerance beyond Q lies within t
/// plus that tolerance of Q. So does everything that the origin touches. No triangle outside the
/// ring (the triangles that share a vertex with this one) comes so close to any point of this
/// triangle. If no triangle of the ring comes so close to Q either, the ray crosses nothing else.
/// Otherwise, let the ring's triangles all face the way the ray goes, and let each of the ring's
/// three fans go around its vertex once. Seen along the ray, triangles of a fan then do not cover
/// each other. So a line through the inside of this triangle meets no other triangle of the ring.
/// Vertices that have moved reduce each distance by twice their deviation and turn each normal by
/// `tilt` times their deviation. During this motion no triangle of a fan turned over, so fans go
/// around as often as before.
PIERCE_HD inline bool is_only_crossing(const TriangleRing& ring, const Crossing& crossing,
                                       Vec3d direction, double deviation, double touch) {
    if (crossing.kind != Crossing::transversal || !(crossing.sign > 0)) return false;
    if (!(crossing.weight[0] > 0) || !(crossing.weight[1] > 0) || !(crossing.weight[2] > 0))
        return false;
    const double near = std::fabs(crossing.t) + 2 * (touch + deviation);
    if (!(near < static_cast<double>(ring.gap))) return false;
    const double sine = static_cast<double>(ring.sine) + static_cast<double>(ring.tilt) * deviation;
    if (dot(to_double(ring.axis), direction) > sine) return true;
    return near < ring_distance(ring, crossing.weight);
}

/// A lower bound of how far the origin of a ray is from a surface, if is_only_crossing() is true of
/// a crossing behind the origin. `height` is the origin's height over the triangle's plane. The
/// point met is `|t|` away, so the other triangles may be nearer to the origin than to the point
/// met by that much.
PIERCE_HD inline double distance_in_front(const TriangleRing& ring, const Crossing& crossing,
                                          double height) {
    const double others = min_of(static_cast<double>(ring.gap),
                                 ring_distance(ring, crossing.weight));
    return min_of(height, others - std::fabs(crossing.t));
}

/// True if the triangle with this ring is certainly the one of the surface that is closest to a
/// point, because it is the only one near. `weight`: the barycentrics of the triangle's point right
/// below or above the point; `height`: how far that is away.
///
/// Proof. The other triangles of the ring are at least as far from the point below as
/// ring_distance() says, all others as far as the ring's gap, less what vertices have moved. So
/// they are further from the point itself than the triangle is, if that is more than twice the
/// height.
PIERCE_HD inline bool is_only_near(const TriangleRing& ring, const double (&weight)[3],
                                   double height, double deviation, double touch) {
    if (!(weight[0] > 0) || !(weight[1] > 0) || !(weight[2] > 0)) return false;
    return 2 * (height + touch + deviation) <
           min_of(static_cast<double>(ring.gap), ring_distance(ring, weight));
}

}  // namespace pierce
