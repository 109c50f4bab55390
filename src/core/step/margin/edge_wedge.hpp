#pragma once

#include "core/body/body_view.hpp"
#include "core/device/rarely.hpp"
#include "core/device/view.hpp"
#include "core/mesh/edge_normal.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/margin/thin_triangles.hpp"
#include "core/step/margin/way_between.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"
#include "pierce/vec3.hpp"

/// Where the points are that are nearest to an edge: in the wedge of the normals of its two
/// triangles.
namespace pierce::stages {

/// The two triangles whose planes meet in an edge: its own, or those beyond triangles without area
/// that lie along it. An edge that is the long side of such a triangle has none: the short sides
/// lie on it, too.
struct EdgeFaces {
    std::uint32_t triangle[2] = {no_triangle, no_triangle};
    std::uint32_t opposite[2] = {no_vertex, no_vertex};  ///< the vertex furthest from the edge

    PIERCE_HD EdgeFaces() = default;
    PIERCE_HD EdgeFaces(const BodyView& body, const Edge& edge) {
        *this = as_given(body.mesh, edge);
        if (exist() && may_have_thin(body)) *this = beyond_thin(body, edge, *this);
    }
    /// The edge's own triangles, with an area or without.
    PIERCE_HD static EdgeFaces as_given(const MeshView& mesh, const Edge& edge) {
        EdgeFaces faces;
        if (edge.triangle[1] == no_triangle) return faces;
        for (int k = 0; k < 2; ++k) faces.opposite[k] = opposite_vertex(mesh, edge, k);
        if (faces.opposite[0] == no_vertex || faces.opposite[1] == no_vertex) return faces;
        for (int k = 0; k < 2; ++k) faces.triangle[k] = edge.triangle[k];
        return faces;
    }

    PIERCE_HD bool exist() const {
        return triangle[0] != no_triangle && triangle[1] != no_triangle;
    }

private:
    PIERCE_HD static std::uint32_t opposite_vertex(const MeshView& mesh, const Edge& edge, int k) {
        std::uint32_t opposite = no_vertex;
        for (std::uint32_t v : mesh.triangles[edge.triangle[k]].vertex)
            if (v != edge.vertex[0] && v != edge.vertex[1]) opposite = v;
        return opposite;
    }

    /// The corner of one of the edge's own triangles that lies opposite the edge.
    PIERCE_HD static std::uint32_t side_of(const MeshView& mesh, std::uint32_t t,
                                           std::uint32_t vertex) {
        const std::uint32_t* corners = mesh.triangles[t].vertex;
        return corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2;
    }

    /// The faces beyond triangles of the edge that have no area.
    PIERCE_RARELY PIERCE_HD static EdgeFaces beyond_thin(const BodyView& body, const Edge& edge,
                                                         EdgeFaces faces) {
        const MeshView& mesh = body.mesh;
        for (int k = 0; k < 2; ++k) {
            const TriangleNow placed(body, edge.triangle[k]);
            if (!placed.is_thin()) continue;
            const std::uint32_t own = opposite_vertex(mesh, edge, k),
                                across = opposite_vertex(mesh, edge, 1 - k);
            const bool is_long_side = placed.longest_side() == side_of(mesh, edge.triangle[k], own);
            faces.triangle[k] = is_long_side ? no_triangle
                                             : neighbor_with_area(
                                                   body, edge.triangle[1 - k],
                                                   side_of(mesh, edge.triangle[1 - k], across));
            if (faces.triangle[k] != no_triangle)
                faces.opposite[k] = furthest_vertex(body, faces.triangle[k], edge);
        }
        return faces;
    }

    /// Of a triangle's vertices, the one that is furthest from the line through an edge.
    PIERCE_HD static std::uint32_t furthest_vertex(const BodyView& body, std::uint32_t triangle,
                                                   const Edge& edge) {
        const Vec3d from = to_double(body.positions[edge.vertex[0]]),
                    along = to_double(body.positions[edge.vertex[1]]) - from;
        std::uint32_t furthest = no_vertex;
        double most = -1;
        for (std::uint32_t v : body.mesh.triangles[triangle].vertex) {
            const double away = length_squared(cross(along, to_double(body.positions[v]) - from));
            if (!(away > most)) continue;
            most = away;
            furthest = v;
        }
        return furthest;
    }
};

/// True for an edge between two faces that bend away from each other outward, by more than `touch`:
/// no point outside is nearest to another edge.
PIERCE_HD inline bool is_ridge(const BodyView& body, const Edge& edge, const EdgeFaces& faces,
                               double touch) {
    return faces.exist() && dot(triangle_normal(body.mesh, body.positions, faces.triangle[0]),
                                to_double(body.positions[faces.opposite[1]]) -
                                    to_double(body.positions[edge.vertex[0]])) < -touch;
}

/// The wedge over an edge between two faces, in the space of a target.
class EdgeWedge {
public:
    PIERCE_HD EdgeWedge(const BodyView& body, const Frame& to_space, const Edge& edge,
                        const EdgeFaces& faces, double touch)
        : touch_(touch) {
        const auto at = [&](std::uint32_t v) {
            return to_space.to_parent(to_double(body.positions[v]));
        };
        from_ = at(edge.vertex[0]);
        for (int k = 0; k < 2; ++k) opposite_[k] = at(faces.opposite[k]);
    }

    /// True if faces() is certainly false of the direction of a way.
    PIERCE_HD bool excludes(const WayBetween& way) const {
        return way.leads_over(opposite_[0] - from_, 1, touch_) ||
               way.leads_over(opposite_[1] - from_, 1, touch_);
    }

    /// True if `direction`, unit, from a point of the edge and at right angles to it, leads away
    /// from both faces.
    PIERCE_HD bool faces(Vec3d direction) const {
        return dot(direction, opposite_[0] - from_) <= touch_ &&
               dot(direction, opposite_[1] - from_) <= touch_;
    }

    /// The unit direction of `way`, from a point of this edge to the closest one of another, which
    /// run `along` and `along_other`; where they touch, the one at right angles to both that leads
    /// away from the faces. Zero where they touch and run the same way.
    PIERCE_HD Vec3d direction_to(Vec3d way, Vec3d along, Vec3d along_other) const {
        const double distance = length(way);
        if (distance > touch_) return (1 / distance) * way;
        const Vec3d across = cross(along, along_other);
        if (!(length_squared(across) > constants::edges_sine * constants::edges_sine *
                                           length_squared(along) * length_squared(along_other)))
            return {};
        const Vec3d direction = normalized(across);
        return faces(direction) ? direction : -direction;
    }

private:
    double touch_;
    Vec3d from_, opposite_[2];
};

/// Around all ways from a ridge that EdgeWedge::faces() is true for and that are not longer than
/// `margin`. Directions between two normals are within the triangle of both and of where the
/// tangents there meet.
PIERCE_HD inline Box reach_of_ridge(const BodyView& body, const Frame& to_space, const Edge& edge,
                                    const EdgeFaces& faces, double margin, double touch) {
    const auto at = [&](std::uint32_t v) { return to_double(body.positions[v]); };
    const Vec3d from = at(edge.vertex[0]), along = normalized(at(edge.vertex[1]) - from);
    Vec3d normal[2];
    double slack = 0;  // the sine of the angle by which EdgeWedge lets directions differ
    for (int k = 0; k < 2; ++k) {
        normal[k] = to_space.rotation *
                    triangle_normal(body.mesh, body.positions, faces.triangle[k]);
        const Vec3d side = at(faces.opposite[k]) - from;
        slack = max_of(slack, touch / length(cross(side, along)));
    }
    const double cosine = dot(normal[0], normal[1]);
    // Where the edge is sharp or a triangle thin, that triangle is large, or not certain.
    if (!(cosine > constants::wedge_cosine) || !(slack < constants::wedge_slack)) {
        const Vec3d all{margin, margin, margin};
        return {-all, all};
    }
    Box box;
    box.extend(Vec3d{});
    for (const Vec3d& n : normal) box.extend(margin * n);
    box.extend(margin / (1 + cosine) * (normal[0] + normal[1]));
    return box.inflated(2 * slack * margin + touch);
}

}  // namespace pierce::stages
