#pragma once

#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/step/solids/rules.hpp"
#include "core/trace/ray.hpp"

/// separation, first part: rays that tell whether a connected part of a body is inside the other.
namespace pierce::stages {

/// True if a vertex of a directed pair's source may be inside the target.
PIERCE_HD inline bool may_be_inside(View<const BodyView> bodies, const DirectedPair& d,
                                    std::uint32_t vertex) {
    const BodyView& target = bodies[d.target];
    const Vec3d start = to_double(bodies[d.source].positions[vertex]);
    return rules::gap_to(target, d.to_fit.to_parent(start)).may_be_inside(target.touch);
}

/// A ray from a vertex of a directed pair's source that shows whether it is inside the target, long
/// enough to leave the target. A vertex in the target's surface is neither inside nor outside; what
/// the source has inside there is ahead of an inward ray. If the vertex has no ray that runs in its
/// own solid, its ray hits nothing.
PIERCE_HD inline Ray ray_through(View<const BodyView> bodies, const DirectedPair& d,
                                 std::uint32_t vertex) {
    const BodyView& source = bodies[d.source];
    const bool has_inside = source.is_solid();
    Ray ray;
    ray.origin = d.to_space.to_parent(to_double(source.positions[vertex]));
    ray.direction = has_inside ? d.to_space.rotation * inward_direction(source, vertex)
                               : any_direction();
    ray.target = d.target;
    ray.touch = d.touch;
    ray.t_max = !has_inside || runs_in_own(source, vertex)
                    ? range_through(bodies[d.target], ray.origin)
                    : -1.0;
    return ray;
}

/// Per directed pair that has no contact with a depth and no vertex inside: lists the rays from the
/// vertices of each of its source's parts. Where surfaces do not cross, a part is inside if one of
/// its vertices is, and not if one is outside; some may lie in the surface, and say nothing. A part
/// with a vertex that is certainly outside gets no rays. If each vertex inside is a contact
/// already, only parts of solids are left all of whose vertices lie in the surface.
struct AskParts {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    PairMarks marks;
    bool inside_is_contact = false;

    static constexpr bool in_order = true;

    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const DirectedPair& d = directed[i];
        if (marks.any(i / 2, PairMarks::vertex_inside | PairMarks::has_depth) ||
            (inside_is_contact &&
             !(marks.any(i / 2, PairMarks::vertex_touches) && bodies[d.source].is_solid())) ||
            !bodies[d.target].is_solid() || d.is_self())
            return 0;
        std::uint32_t count = 0;
        for (const MeshPart& part : bodies[d.source].mesh.parts) count += may_hold(d, part);
        return count;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t found) { return MeshPart::count * found; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t found, std::uint32_t place, Ray* rays,
                         RaySource* sources) const {
        if (found == 0) return;
        const DirectedPair& d = directed[i];
        for (const MeshPart& part : bodies[d.source].mesh.parts) {
            if (!may_hold(d, part)) continue;
            for (std::uint32_t v : part.vertex) {
                rays[place] = ray_through(bodies, d, v);
                sources[place++] = {i / 2, part.vertex[0], static_cast<std::uint8_t>(i % 2)};
            }
        }
    }

private:
    PIERCE_HD bool may_hold(const DirectedPair& d, const MeshPart& part) const {
        for (std::uint32_t v : part.vertex)
            if (!may_be_inside(bodies, d, v)) return false;
        return true;
    }
};

}  // namespace pierce::stages
