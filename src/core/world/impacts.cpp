#include <algorithm>

#include "core/mesh_build/box_tree.hpp"
#include "core/overlap/face_parts.hpp"
#include "core/overlap/first_meeting.hpp"
#include "core/world/world_state.hpp"
#include "pierce/error.hpp"
#include "pierce/impact_contact.hpp"

namespace pierce {
namespace {

/// True if the solids overlap, or one is inside the other, at time 0.
bool overlap_at_start(const MovingSurface& a, const MovingSurface& b) {
    Box box_a, box_b;
    for (const MovingPoint& p : a.points) box_a.extend(p.start);
    for (const MovingPoint& p : b.points) box_b.extend(p.start);
    if (!overlap(box_a, box_b)) return false;
    Box around = box_a;
    around.extend(box_b);
    const Grid grid(around);
    std::vector<GridPoint> points[2];
    for (const MovingPoint& p : a.points) points[0].push_back(grid.point(p.start));
    for (const MovingPoint& p : b.points) points[1].push_back(grid.point(p.start));
    const FaceParts parts = find_face_parts(grid, {points[0], a.triangles},
                                            {points[1], b.triangles});
    return !parts.of[0].empty() || !parts.of[1].empty();
}

}  // namespace

std::vector<ImpactContact> World::impacts() const {
    const State& s = *state_;
    const auto& slots = s.bodies.slots();
    const auto surface_of = [&](std::uint32_t i) {
        const BodyEntry& body = slots[i].thing;
        const Mesh& mesh = s.mesh_of(body);
        MovingSurface surface{{}, mesh.triangles()};
        const Frame end = frame_of(body.pose), start = body.moved ? frame_of(body.start_pose) : end;
        for (std::size_t v = 0; v < mesh.positions().size(); ++v) {
            const Vec3d rest = to_double(mesh.positions()[v]);
            if (body.motion != Motion::deforming)
                surface.points.push_back({start.to_parent(rest), end.to_parent(rest)});
            else
                surface.points.push_back({to_double(body.moved ? body.start[v] : body.positions[v]),
                                          to_double(body.positions[v])});
        }
        return surface;
    };
    std::vector<std::uint32_t> bodies;
    std::vector<MovingSurface> surfaces;
    std::vector<Box> boxes;
    for (std::uint32_t i = 0; i < slots.size(); ++i) {
        if (!slots[i].used) continue;
        const BodyEntry& body = slots[i].thing;
        if (body.is_on_device())
            throw InputError("body " + std::to_string(i) + " has its place in device memory");
        if (!body.usable || s.left_out.contains(body.filter.world) || body.collision.sheet ||
            !s.mesh_of(body).inside().exists())
            continue;
        bodies.push_back(i);
        surfaces.push_back(surface_of(i));
        boxes.push_back(surfaces.back().box());
    }
    std::vector<ImpactContact> found;
    if (bodies.empty()) return found;
    const BoxTree tree(boxes);
    for (std::uint32_t k = 0; k < bodies.size(); ++k) {
        std::vector<std::uint32_t> partners;
        tree.for_each_in(boxes[k], [&](std::uint32_t other) {
            if (other > k) partners.push_back(other);
        });
        std::ranges::sort(partners);
        for (const std::uint32_t other : partners) {
            const BodyEntry &a = slots[bodies[k]].thing, &b = slots[bodies[other]].thing;
            const BodyId id_a{bodies[k], slots[bodies[k]].generation},
                id_b{bodies[other], slots[bodies[other]].generation};
            if (!(a.moved || b.moved) || !a.filter.allows(b.filter) ||
                s.excluded.contains({id_a, id_b}) || (s.pair_filter && !s.pair_filter(id_a, id_b)))
                continue;
            const std::optional<FirstMeeting> meeting = first_meeting(surfaces[k], surfaces[other]);
            if (!meeting || overlap_at_start(surfaces[k], surfaces[other])) continue;
            found.push_back({.a = id_a,
                             .b = id_b,
                             .time = meeting->time,
                             .point = meeting->place,
                             .normal = meeting->normal,
                             .gap = meeting->gap,
                             .edges = meeting->edges,
                             .source = meeting->vertex_of_second ? Side::b : Side::a,
                             .vertex = meeting->vertex,
                             .edge_end = meeting->edges ? meeting->edge_end : no_vertex,
                             .triangle = meeting->triangle});
        }
    }
    return found;
}

}  // namespace pierce
