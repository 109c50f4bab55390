#include "core/mesh_build/own_exits.hpp"

#include <utility>

#include "core/base/workers.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/constants.hpp"

namespace pierce {

std::vector<double> own_exits_of(const MeshView& mesh, Workers& workers) {
    const Surface surface{mesh.positions, mesh.triangles,
                          constants::touch_tolerance * mesh.box.extent()};
    std::vector<Box> boxes(mesh.triangles.size);
    for (std::uint32_t t = 0; t < mesh.triangles.size; ++t) {
        for (std::uint32_t v : mesh.triangles[t].vertex)
            boxes[t].extend(to_double(mesh.positions[v]));
        // A ray in a triangle's plane touches the triangle from as far away as the touch tolerance.
        boxes[t] = boxes[t].inflated(constants::tree_margin * mesh.box.max_coordinate() +
                                     surface.touch);
    }
    const BoxTree tree(std::move(boxes));

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
            tree.for_each_that(
                [&](const Box& box) {
                    const Stretch inside = stretch_inside(box, ray.origin, ray.direction);
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
