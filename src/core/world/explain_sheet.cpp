#include "core/world/explain_sheet.hpp"

#include <algorithm>
#include <cmath>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/geometry/closest_point.hpp"
#include "core/mesh/mesh_view.hpp"

namespace pierce {
namespace {

struct Corners {
    Vec3d at[3];

    Corners(const Frame& space, View<const Vec3f> positions, const Triangle& t) {
        for (int k = 0; k < 3; ++k) at[k] = space.to_parent(to_double(positions[t.vertex[k]]));
    }
    double distance(Vec3d p) const {
        return length(p - closest_on_triangle(p, at[0], at[1], at[2]));
    }
    /// True if the projection of `p` onto the triangle's plane lies in the triangle.
    bool is_under(Vec3d p) const {
        const Vec3d n = cross(at[1] - at[0], at[2] - at[0]);
        for (int k = 0; k < 3; ++k)
            if (dot(cross(n, at[(k + 1) % 3] - at[k]), p - at[k]) < 0) return false;
        return true;
    }
};

}  // namespace

Explanation explain_sheet(const BodyView& source, const BodyView& target, std::uint32_t vertex,
                          double thickness, std::span<const Contact> contacts) {
    Explanation result;
    if (!contacts.empty()) {
        result.contact = *std::ranges::min_element(contacts, {}, &Contact::distance);
        result.triangle = result.contact->triangle;
        result.distance = std::fabs(result.contact->distance);
        return result;
    }
    const auto because = [&](Reason reason) {
        result.reason = reason;
        return result;
    };
    const bool self = &source == &target;
    if (!source.active || !target.active) return because(Reason::excluded);
    if (self && source.collision.self != SelfCollision::on) return because(Reason::not_looked_for);

    const Vec3d p = source.space.to_parent(to_double(source.positions[vertex]));
    result.distance = INFINITY;
    bool is_over = false;
    for (std::uint32_t t = 0; t < target.mesh.triangles.size; ++t) {
        const Triangle& triangle = target.mesh.triangles[t];
        if (self && has_vertex(triangle, vertex)) continue;
        const Corners corners(target.space, target.positions, triangle);
        const double distance = corners.distance(p);
        is_over |= distance < thickness && corners.is_under(p);
        if (distance < result.distance) {
            result.distance = distance;
            result.triangle = t;
        }
    }
    if (result.distance >= thickness) return because(Reason::apart);
    return because(is_over && self ? Reason::close_at_rest : Reason::beside);
}

}  // namespace pierce
