#pragma once

#include <numbers>

#include "core/body/body_view.hpp"
#include "core/device/rarely.hpp"
#include "core/device/view.hpp"
#include "core/geometry/solid_angle.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/margin/edge_wedge.hpp"
#include "core/step/margin/thin_triangles.hpp"
#include "pierce/vec3.hpp"

/// Ridges that lie in other parts of their own surface: these are no ridges of the solid.
namespace pierce::stages {

/// How much of a ridge other parts may cover.
PIERCE_HD inline Cover cover_of(const BodyView& body, const EdgeFaces& faces) {
    const View<const Cover>& covered = body.mesh.covered;
    if (covered.size == 0) return Cover::none;
    const Cover one = covered[faces.triangle[0]], other = covered[faces.triangle[1]];
    if (one == Cover::wholly || other == Cover::wholly) return Cover::wholly;
    return one == Cover::partly || other == Cover::partly ? Cover::partly : Cover::none;
}

/// True if the surface winds around a point of its body's space. Looks at all triangles.
PIERCE_RARELY PIERCE_HD inline bool winds_around(const BodyView& body, Vec3d point) {
    double angle = 0;
    for (std::uint32_t t = 0; t < body.mesh.triangles.size; ++t) {
        const TriangleNow now(body, t);
        angle += solid_angle(now.corner[0] - point, now.corner[1] - point, now.corner[2] - point);
    }
    return angle > 2 * std::numbers::pi;
}

/// True if a place on a ridge, in its body's space, lies in another part. `out`: unit, leads out of
/// the ridge's own part.
PIERCE_HD inline bool is_covered(const BodyView& body, const EdgeFaces& faces, Vec3d place,
                                 Vec3d out) {
    const Cover cover = cover_of(body, faces);
    return cover == Cover::wholly ||
           (cover == Cover::partly && winds_around(body, place + 2 * body.touch * out));
}

}  // namespace pierce::stages
