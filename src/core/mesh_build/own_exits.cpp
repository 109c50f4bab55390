#include "core/mesh_build/own_exits.hpp"

#include "core/base/workers.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

namespace pierce {
namespace {

/// Calls visit(triangle) for each triangle of the rest shape whose box `wanted` is true for; it
/// must be true for every box around such a box, too.
template <class Wanted, class Visit>
void for_each_triangle_that(const MeshView& mesh, const BoxLevels& levels, const Wanted& wanted,
                            const Visit& visit) {
    const auto look = [&](const auto& self, std::uint32_t level, std::uint32_t place) -> void {
        const BoxNode& node = mesh.box_nodes[levels.begin[level] + place];
        if (!wanted(node.around)) return;
        const std::uint32_t first = place * constants::group_size;
        const std::uint32_t below = level == 0 ? mesh.triangles.size
                                               : levels.begin[level] - levels.begin[level - 1];
        for (std::uint32_t k = first; k < min_of(first + constants::group_size, below); ++k) {
            if (level > 0)
                self(self, level - 1, k);
            else if (wanted(box_of(mesh, mesh.positions, mesh.group_triangles[k])))
                visit(mesh.group_triangles[k]);
        }
    };
    look(look, levels.count - 1, 0);
}

}  // namespace

std::vector<double> own_exits_of(const MeshView& mesh, Workers& workers) {
    const Surface surface{.positions = mesh.positions,
                          .triangles = mesh.triangles,
                          .touch = constants::touch_tolerance * mesh.box.extent(),
                          .covered = mesh.covered};
    // A ray in a triangle's plane touches the triangle from as far away as the touch tolerance.
    const double margin = constants::tree_margin * mesh.box.max_coordinate() + surface.touch;
    const BoxLevels levels(mesh.triangles.size);

    std::vector<double> exits(mesh.positions.size, -1.0);
    const auto find = [&](std::uint32_t v) {
        Ray ray;
        ray.origin = to_double(mesh.positions[v]);
        ray.direction = -normalized(to_double(mesh.normals[v]));
        if (length_squared(ray.direction) == 0) return;
        ray.t_max = mesh.box.extent();
        ray.touch = surface.touch;
        ray.excluded[0] = ray.excluded[1] = v;
        const Hit hit = first_crossing(ray, surface, [&](CrossingSearch& search) {
            for_each_triangle_that(
                mesh, levels,
                [&](const QuickBox& box) {
                    const Box around{to_double(box.lower), to_double(box.upper)};
                    const Stretch inside = stretch_inside(around.inflated(margin), ray.origin,
                                                          ray.direction);
                    return inside.begin <= inside.end && inside.end >= search.begin() &&
                           inside.begin <= search.limit();
                },
                [&](std::uint32_t t) { search.test(t); });
        });
        if (hit.triangle == no_triangle) return;
        const Meeting exit = meet(ray, surface, hit.triangle);
        if (exit.exit) exits[v] = exit.t;
    };
    constexpr std::uint32_t vertices_at_once = 256;
    workers.share_out("own exits", mesh.positions.size, vertices_at_once,
                      [&](std::uint32_t begin, std::uint32_t end) {
                          for (std::uint32_t v = begin; v < end; ++v) find(v);
                      });
    return exits;
}

}  // namespace pierce
