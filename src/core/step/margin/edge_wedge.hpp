#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/edge_normal.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/margin/thin_triangles.hpp"
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

    PIERCE_HD EdgeFaces(const BodyView& body, const Edge& edge) {
        if (edge.triangle[1] == no_triangle) return;
        for (int k = 0; k < 2; ++k) {
            triangle[k] = edge.triangle[k];
            opposite[k] = opposite_vertex(body.mesh, edge, k);
        }
        if (opposite[0] == no_vertex || opposite[1] == no_vertex)
            triangle[0] = triangle[1] = no_triangle;
        else if (may_have_thin(body))
            for (int k = 0; k < 2; ++k) look_beyond_thin(body, edge, k);
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

    PIERCE_HD void look_beyond_thin(const BodyView& body, const Edge& edge, int k) {
        const MeshView& mesh = body.mesh;
        const TriangleNow placed(body, edge.triangle[k]);
        if (!placed.is_thin()) return;
        const int other = 1 - k;
        const std::uint32_t own = opposite_vertex(mesh, edge, k),
                            own_side = side_of(mesh, edge.triangle[k], own),
                            other_side = side_of(mesh, edge.triangle[other],
                                                 opposite_vertex(mesh, edge, other));
        triangle[k] = placed.longest_side() == own_side
                          ? no_triangle
                          : neighbor_with_area(body, edge.triangle[other], other_side);
        if (triangle[k] == no_triangle) return;
        const Vec3d from = to_double(body.positions[edge.vertex[0]]),
                    along = to_double(body.positions[edge.vertex[1]]) - from;
        double furthest = -1;
        for (std::uint32_t v : mesh.triangles[triangle[k]].vertex) {
            const double away = length_squared(cross(along, to_double(body.positions[v]) - from));
            if (!(away > furthest)) continue;
            furthest = away;
            opposite[k] = v;
        }
    }
};

/// True for an edge between two faces that bend away from each other outward, by more than `touch`:
/// no point outside is nearest to another edge.
PIERCE_HD inline bool is_ridge(const BodyView& body, const Edge& edge, double touch) {
    const EdgeFaces faces(body, edge);
    return faces.exist() && dot(triangle_normal(body.mesh, body.positions, faces.triangle[0]),
                                to_double(body.positions[faces.opposite[1]]) -
                                    to_double(body.positions[edge.vertex[0]])) < -touch;
}

/// The plane through a segment at right angles to a triangle of which it is a side. What is nearest
/// to a point inside the segment is not on the triangle's side of it.
class WedgeSide {
public:
    PIERCE_HD WedgeSide(Vec3d from, Vec3d to, Vec3d opposite) : from_(from) {
        const Vec3d along = to - from, side = opposite - from;
        length_squared_ = length_squared(along);
        normal_ = length_squared_ * side - dot(side, along) * along;
        height_ = length(normal_);
    }

    /// True if no point of the segment from `a` to `b` that is nearer than `margin` is nearest to a
    /// point inside this one, where directions may differ as EdgeWedge::faces() lets them.
    PIERCE_HD bool excludes(Vec3d a, Vec3d b, double margin, double touch) const {
        return min_of(dot(normal_, a - from_), dot(normal_, b - from_)) >
               touch * (margin * length_squared_ + height_);
    }

private:
    Vec3d from_, normal_;  // the normal times the triangle's height and the square of the length
    double length_squared_, height_;
};

/// The wedge over an edge between two faces, in the space of a target.
class EdgeWedge {
public:
    PIERCE_HD EdgeWedge(const BodyView& body, const Frame& to_space, const Edge& edge, double touch)
        : touch_(touch) {
        const auto at = [&](std::uint32_t v) {
            return to_space.to_parent(to_double(body.positions[v]));
        };
        from_ = at(edge.vertex[0]);
        to_ = at(edge.vertex[1]);
        const EdgeFaces faces(body, edge);
        for (int k = 0; k < 2; ++k) opposite_[k] = at(faces.opposite[k]);
    }

    /// The sides of its two faces.
    PIERCE_HD WedgeSide side(int k) const { return {from_, to_, opposite_[k]}; }

    /// True if `direction`, unit, from a point of the edge and at right angles to it, leads away
    /// from both faces.
    PIERCE_HD bool faces(Vec3d direction) const {
        return dot(direction, opposite_[0] - from_) <= touch_ &&
               dot(direction, opposite_[1] - from_) <= touch_;
    }

private:
    double touch_;
    Vec3d from_, to_, opposite_[2];
};

/// Around all ways from a ridge that EdgeWedge::faces() is true for and that are not longer than
/// `margin`. Directions between two normals are within the triangle of both and of where the
/// tangents there meet.
PIERCE_HD inline Box reach_of_ridge(const BodyView& body, const Frame& to_space, const Edge& edge,
                                    double margin, double touch) {
    const auto at = [&](std::uint32_t v) { return to_double(body.positions[v]); };
    const Vec3d from = at(edge.vertex[0]), along = normalized(at(edge.vertex[1]) - from);
    Vec3d normal[2];
    double slack = 0;  // the sine of the angle by which EdgeWedge lets directions differ
    const EdgeFaces faces(body, edge);
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
