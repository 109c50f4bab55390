#pragma once

#include <cmath>

#include "core/body/body_view.hpp"
#include "core/device/rarely.hpp"
#include "core/device/view.hpp"
#include "core/geometry/closest_place_on_triangle.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/edge_normal.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/vertex_normal.hpp"
#include "core/step/margin/thin_triangles.hpp"
#include "pierce/constants.hpp"

/// The normal of a surface at any place of it.
namespace pierce::stages {

/// Of the triangles at a vertex, or at the edge between two, the normal of the one whose plane is
/// furthest from the end of `way`. It stands for all of them where they are not one fan, or not
/// two.
PIERCE_HD inline Vec3d most_facing_normal(const BodyView& body, Vec3d way, std::uint32_t v,
                                          std::uint32_t other = no_vertex) {
    const Vec3d apex = to_double(body.positions[v]);
    Vec3d best;
    double most = -1;
    for (std::uint32_t i = body.mesh.corner_offsets[v]; i < body.mesh.corner_offsets[v + 1]; ++i) {
        const Corner& corner = body.mesh.corners[i];
        if (other != no_vertex && corner.next != other && corner.previous != other) continue;
        const Vec3d next = to_double(body.positions[corner.next]),
                    previous = to_double(body.positions[corner.previous]);
        if (is_degenerate(apex, next, previous)) continue;
        const Vec3d normal = normalized(cross(next - apex, previous - apex));
        const double height = std::fabs(dot(normal, way));
        if (!(height > most)) continue;
        most = height;
        best = normal;
    }
    return best;
}

/// The edge or the corner of a triangle on which a place lies, or neither.
struct PlaceKind {
    std::uint32_t zeros = 0;   ///< weights that are zero: 0 inside, 1 on an edge, 2 in a corner
    std::uint32_t zero = 3;    ///< the last corner whose weight is zero: the edge lies opposite
    std::uint32_t corner = 0;  ///< the last one whose weight is not

    // A weight is a difference of numbers up to one.
    PIERCE_HD static bool is_zero(double weight) { return !(weight > constants::double_rounding); }

    PIERCE_HD explicit PlaceKind(const double weight[3]) {
        for (std::uint32_t k = 0; k < 3; ++k)
            if (is_zero(weight[k])) {
                zero = k;
                ++zeros;
            } else {
                corner = k;
            }
    }
};

/// True if a triangle at the edge or the corner that a place lies on has no area.
PIERCE_HD inline bool lies_on_thin(const BodyView& body, std::uint32_t triangle,
                                   const PlaceKind& place) {
    if (place.zeros == 0 || !may_have_thin(body)) return false;
    const MeshView& mesh = body.mesh;
    if (place.zeros == 1) {
        const std::uint32_t across = mesh.neighbors[triangle].across[place.zero];
        return across != no_triangle && TriangleNow(body, across).is_thin();
    }
    const std::uint32_t v = mesh.triangles[triangle].vertex[place.corner];
    const auto at = [&](std::uint32_t u) { return to_double(body.positions[u]); };
    for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i)
        if (is_degenerate(at(v), at(mesh.corners[i].next), at(mesh.corners[i].previous)))
            return true;
    return false;
}

/// normal_at() beside triangles without area: of the triangles at the place and of those beyond,
/// as most_facing_normal().
PIERCE_RARELY PIERCE_HD inline Vec3d normal_beside_thin(const BodyView& body,
                                                        std::uint32_t triangle, TrianglePlace at,
                                                        Vec3d way) {
    const double weight[3] = {1 - at.second - at.third, at.second, at.third};
    const PlaceKind place(weight);
    const MeshView& mesh = body.mesh;
    Vec3d best = place.zeros == 2
                     ? most_facing_normal(body, way, mesh.triangles[triangle].vertex[place.corner])
                     : triangle_normal(mesh, body.positions, triangle);
    for (std::uint32_t k = 0; k < 3; ++k) {
        if (!PlaceKind::is_zero(weight[k])) continue;
        const std::uint32_t beside = neighbor_with_area(body, triangle, k);
        if (beside == no_triangle) continue;
        const Vec3d normal = triangle_normal(mesh, body.positions, beside);
        if (std::fabs(dot(normal, way)) > std::fabs(dot(best, way))) best = normal;
    }
    return best;
}

/// The outward normal of a surface where it is closest to the end of `way`, a point outside or
/// inside of it: of the triangle, of its edge or of its corner. Its sign tells on which side the
/// point is (Baerentzen and Aanaes 2005). Not of length 1.
PIERCE_HD inline Vec3d normal_at(const BodyView& body, std::uint32_t triangle,
                                 const TrianglePlace& at, Vec3d way) {
    const MeshView& mesh = body.mesh;
    const Triangle& t = mesh.triangles[triangle];
    const double weight[3] = {1 - at.second - at.third, at.second, at.third};
    const PlaceKind place(weight);
    if (lies_on_thin(body, triangle, place)) return normal_beside_thin(body, triangle, at, way);
    const std::uint32_t v = t.vertex[place.corner];
    if (place.zeros == 2) {
        const bool is_one_fan = mesh.fans[mesh.corner_offsets[v]] != no_vertex;
        const Vec3d normal = is_one_fan ? vertex_normal(mesh, body.positions, v) : Vec3d{};
        return length_squared(normal) > 0 ? normal : most_facing_normal(body, way, v);
    }
    const Vec3d normal = triangle_normal(mesh, body.positions, triangle);
    if (place.zeros == 0) return normal;
    const std::uint32_t across = mesh.neighbors[triangle].across[place.zero];
    const Vec3d both = across == no_triangle
                           ? Vec3d{}
                           : normal + triangle_normal(mesh, body.positions, across);
    return length_squared(both) > 0
               ? both
               : most_facing_normal(body, way, v, t.vertex[3 - place.zero - place.corner]);
}

/// The normal of the surface for what touches it at a place, within `touch` [length], and goes on
/// along `inward`, a direction into its own body: of the triangle there, or, on an edge or in a
/// corner, of that triangle around it which faces `inward` most. Not of length 1.
PIERCE_HD inline Vec3d normal_touched(const BodyView& body, std::uint32_t triangle,
                                      const TrianglePlace& at, Vec3d inward, double touch) {
    const MeshView& mesh = body.mesh;
    const TriangleCorners corners = body.surface().corners(triangle);
    const double per_height = touch / length(corners.normal());
    double weight[3] = {1 - at.second - at.third, at.second, at.third};
    const double side[3] = {length(corners.c - corners.b), length(corners.a - corners.c),
                            length(corners.b - corners.a)};
    for (int k = 0; k < 3; ++k)
        if (weight[k] <= per_height * side[k]) weight[k] = 0;
    const PlaceKind place(weight);
    Vec3d best = triangle_normal(mesh, body.positions, triangle);
    const auto consider = [&](Vec3d normal) {
        if (!(length_squared(normal) > 0)) return;  // no area
        if (!(length_squared(best) > 0) || dot(normal, inward) > dot(best, inward)) best = normal;
    };
    if (place.zeros == 1) {
        const std::uint32_t across = mesh.neighbors[triangle].across[place.zero];
        if (across != no_triangle) consider(triangle_normal(mesh, body.positions, across));
    } else if (place.zeros == 2) {
        const std::uint32_t v = mesh.triangles[triangle].vertex[place.corner];
        const auto from = [&](std::uint32_t u) {
            return to_double(body.positions[u]) - to_double(body.positions[v]);
        };
        for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i)
            consider(normalized(cross(from(mesh.corners[i].next), from(mesh.corners[i].previous))));
    }
    return best;
}

}  // namespace pierce::stages
