#pragma once

#include <numbers>

#include "core/body/body_view.hpp"
#include "core/geometry/solid_angle.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/margin/edge_wedge.hpp"
#include "core/step/margin/thin_triangles.hpp"
#include "pierce/vec3.hpp"

/// Ridges that lie in other parts of their own surface: these are no ridges of the solid.
namespace pierce::stages {

/// How much of a ridge other parts may cover.
PIERCE_HD inline Cover cover_of(const BodyView& body, const Edge& edge) {
    const View<const Cover> covered = body.surface().covered;
    if (covered.size == 0) return Cover::none;
    const EdgeFaces faces(body, edge);
    const Cover one = covered[faces.triangle[0]], other = covered[faces.triangle[1]];
    if (one == Cover::wholly || other == Cover::wholly) return Cover::wholly;
    return one == Cover::partly || other == Cover::partly ? Cover::partly : Cover::none;
}

/// True if a place on a ridge, in its body's space, lies in another part. `out`: unit, leads out of
/// the ridge's own part. Takes a look at all triangles where parts may cover some of the ridge.
PIERCE_HD inline bool is_covered(const BodyView& body, const Edge& edge, Vec3d place, Vec3d out) {
    const Cover cover = cover_of(body, edge);
    if (cover != Cover::partly) return cover == Cover::wholly;
    const Vec3d outside = place + 2 * body.touch * out;
    double angle = 0;
    for (std::uint32_t t = 0; t < body.mesh.triangles.size; ++t) {
        const TriangleNow now(body, t);
        angle += solid_angle(now.corner[0] - outside, now.corner[1] - outside,
                             now.corner[2] - outside);
    }
    return angle > 2 * std::numbers::pi;
}

}  // namespace pierce::stages
