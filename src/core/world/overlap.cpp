#include "pierce/overlap.hpp"

#include "core/mesh/used_vertices.hpp"
#include "core/overlap/patches.hpp"
#include "core/world/world_state.hpp"
#include "pierce/error.hpp"
#include "pierce/world.hpp"

namespace pierce {
namespace {

std::vector<GridPoint> on_grid(const Grid& grid, const std::vector<Vec3d>& places) {
    std::vector<GridPoint> points;
    points.reserve(places.size());
    for (const Vec3d& p : places) points.push_back(grid.point(p));
    return points;
}

Overlap overlap_of(const FaceParts& parts) {
    Overlap result;
    Vec3d center;
    for (int side = 0; side < 2; ++side)
        for (const FacePart& part : parts.of[side]) {
            // The divergence theorem, with x x / 2 along x for the centre.
            result.volume += volume_of(part);
            for (int k = 0; k < 3; ++k) center[k] += 0.5 * part.squares[k] * part.normal[k];
            (side == 0 ? result.area_a : result.area_b) += part.area;
            if (side == 1) continue;
            result.push += part.area * part.normal;
            result.turn += cross(part.moment, part.normal);
        }
    if (result.volume > 0) result.center = 1 / result.volume * center;
    result.turn -= cross(result.center, result.push);
    return result;
}

}  // namespace

std::optional<Overlap> World::overlap(BodyId a, BodyId b, double same_direction) {
    if (a == b) throw InputError("a body overlaps itself as a whole");
    if (!(same_direction >= -1 && same_direction <= 1))
        throw InputError("same_direction is a cosine");
    const auto places = [&](BodyId id) {
        const BodyEntry& body = state_->placed_body(id);
        const Mesh& mesh = state_->mesh_of(body);
        if (body.collision.sheet || !mesh.inside().exists())
            throw InputError("body " + std::to_string(id.index) + " of mesh '" + mesh.name() +
                             "' has no inside");
        std::vector<Vec3d> result;
        const Frame frame = frame_of(body.pose);
        for (const std::uint32_t v : stand_ins(mesh.triangles(), mesh.positions().size()))
            result.push_back(body.motion == Motion::deforming
                                 ? to_double(body.positions[v])
                                 : frame.to_parent(to_double(mesh.positions()[v])));
        return result;
    };
    const std::array<std::vector<Vec3d>, 2> at{places(a), places(b)};
    const std::array<const BodyEntry*, 2> bodies{&state_->bodies.get(a, "body"),
                                                 &state_->bodies.get(b, "body")};
    if (!bodies[0]->is_placed() || !bodies[1]->is_placed()) return std::nullopt;
    Box boxes[2];
    for (int side = 0; side < 2; ++side)
        for (const Vec3d& p : at[static_cast<std::size_t>(side)]) boxes[side].extend(p);
    if (!pierce::overlap(boxes[0], boxes[1])) return std::nullopt;
    Box around = boxes[0];
    around.extend(boxes[1]);
    const Grid grid(around);
    const std::array<std::vector<GridPoint>, 2> points{on_grid(grid, at[0]), on_grid(grid, at[1])};
    const std::array<GridSurface, 2> surfaces{
        GridSurface{points[0], state_->mesh_of(*bodies[0]).triangles()},
        GridSurface{points[1], state_->mesh_of(*bodies[1]).triangles()}};
    const FaceParts parts = find_face_parts(grid, surfaces[0], surfaces[1]);
    Overlap result = overlap_of(parts);
    // What is thinner than the positions are rounded is none.
    if (!(result.volume > grid.step() * (result.area_a + result.area_b))) return std::nullopt;
    result.patches = find_patches(grid, surfaces, parts, same_direction);
    result.center += parts.origin + grid.origin();
    for (ContactPatch& patch : result.patches) {
        patch.center += grid.origin();
        patch.deepest += grid.origin();
    }
    return result;
}

}  // namespace pierce
