#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"
#include "pierce/vec3.hpp"

/// Triangles without area where their body is now. They have no normal: what lies on one lies on
/// those beyond it, too.
namespace pierce::stages {

/// True if a body may have such triangles: those of a deforming one may come at any time.
PIERCE_HD inline bool may_have_thin(const BodyView& body) {
    return body.mesh.has_degenerate || body.motion == Motion::deforming;
}

/// The corners of a triangle where its body is now, in the body's space.
struct TriangleNow {
    Vec3d corner[3];

    PIERCE_HD TriangleNow(const BodyView& body, std::uint32_t triangle) {
        const Triangle& t = body.mesh.triangles[triangle];
        for (int k = 0; k < 3; ++k) corner[k] = to_double(body.positions[t.vertex[k]]);
    }

    PIERCE_HD bool is_thin() const { return is_degenerate(corner[0], corner[1], corner[2]); }
    /// Of a thin triangle, this side is as long as the two others together. Sides are named by the
    /// corner opposite to them.
    PIERCE_HD std::uint32_t longest_side() const {
        const auto squared = [&](std::uint32_t side) {
            return length_squared(corner[(side + 1) % 3] - corner[(side + 2) % 3]);
        };
        const std::uint32_t longest = squared(1) > squared(0) ? 1 : 0;
        return squared(2) > squared(longest) ? 2 : longest;
    }
};

/// The triangle beside a triangle's side, or beyond those without area that lie there; no_triangle
/// if there is none.
PIERCE_HD inline std::uint32_t neighbor_with_area(const BodyView& body, std::uint32_t triangle,
                                                  std::uint32_t side) {
    const MeshView& mesh = body.mesh;
    std::uint32_t last = triangle, next = mesh.neighbors[triangle].across[side];
    for (std::uint32_t k = 0; k < constants::degenerate_in_a_row && next != no_triangle; ++k) {
        const TriangleNow placed(body, next);
        if (!placed.is_thin()) return next;
        const std::uint32_t longest = placed.longest_side();
        const std::uint32_t* across = mesh.neighbors[next].across;
        const std::uint32_t out = across[longest] == last ? (longest + 1) % 3 : longest;
        last = next;
        next = across[out];
    }
    return no_triangle;
}

}  // namespace pierce::stages
