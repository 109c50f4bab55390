#pragma once

#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/geometry/closest_points_of_segments.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/trace/ray.hpp"

namespace pierce::stages {

/// The triangles through which an edge may be said to cross a surface at a point: the one that was
/// found, those beside it in its plane, and those across an edge that the point is on. Which of
/// them was found is a matter of how faces are divided, or of the order of triangles.
struct CrossedTriangles {
    std::uint32_t count = 0;
    std::uint32_t triangle[4];

    PIERCE_HD CrossedTriangles(const BodyView& target, std::uint32_t found, Vec3d point) {
        const View<const Vec3f> positions = target.positions;
        const Triangle& t = target.mesh.triangles[found];
        triangle[count++] = found;
        Vec3d corner[3];
        for (int k = 0; k < 3; ++k) corner[k] = to_double(positions[t.vertex[k]]);
        const Vec3d normal = normalized(cross(corner[1] - corner[0], corner[2] - corner[0]));
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t across = target.mesh.neighbors[found].across[k];
            if (across == no_triangle) continue;
            const Vec3d from = corner[k == 2 ? 0 : k + 1], to = corner[k == 0 ? 2 : k - 1];
            const double place = closest_place_on_segment(point, from, to - from);
            bool joins = length(from + place * (to - from) - point) <= target.touch;
            bool in_plane = true;
            for (std::uint32_t v : target.mesh.triangles[across].vertex)
                in_plane &= std::fabs(dot(normal, to_double(positions[v]) - corner[0])) <=
                            target.touch;
            joins |= in_plane;
            if (joins) triangle[count++] = across;
        }
    }
};

/// A chord that enters and leaves a target through two triangles with a common edge, the ridge: the
/// ridge, and the place along the chord's edge that is closest to it. There the way to the ridge is
/// at right angles to both edges, so it is the shortest way on which the edge leaves the wedge
/// between the two triangles. Of several ridges, the closest one counts. There is none where other
/// parts of the target cover it.
struct OverRidge {
    Ridge ridge;
    double along = 0;  ///< from 0 at the edge's first vertex to 1 at its second

    PIERCE_HD OverRidge(const BodyView& target, const PlacedEdge& edge,
                        const CrossedTriangles& entered, const CrossedTriangles& left) {
        double least = 0;
        for (std::uint32_t i = 0; i < entered.count; ++i)
            for (std::uint32_t k = 0; k < left.count; ++k)
                look(target, edge, entered.triangle[i], left.triangle[k], least);
    }
    PIERCE_HD bool exists() const { return ridge.exists(); }

private:
    /// There is no ridge if the triangles share no edge, or if the way to it meets it in an end.
    PIERCE_HD void look(const BodyView& target, const PlacedEdge& edge, std::uint32_t entered,
                        std::uint32_t left, double& least) {
        const Triangle &t = target.mesh.triangles[entered], &other = target.mesh.triangles[left];
        const View<const Cover> covered = target.mesh.covered;
        if (covered.size > 0 && (covered[entered] != Cover::none || covered[left] != Cover::none))
            return;
        std::uint32_t apart = 0, corner = 0;
        for (std::uint32_t k = 0; k < 3; ++k)
            if (!has_vertex(other, t.vertex[k])) {
                ++apart;
                corner = k;
            }
        if (apart != 1) return;
        const RidgeEnds ends(target.surface(), {entered, corner});
        const SegmentPlaces places = closest_points_of_segments(edge.a, edge.b, ends.from, ends.to);
        const double distance = length(edge.a + places.first * (edge.b - edge.a) - ends.from -
                                       places.second * (ends.to - ends.from));
        if (!(places.second > 0 && places.second < 1) || (exists() && !(distance < least))) return;
        least = distance;
        ridge = {entered, corner};
        along = places.first;
    }
};

}  // namespace pierce::stages
