#include "core/mesh_build/star_clearance.hpp"

#include <algorithm>

#include "core/geometry/closest_point.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "pierce/constants.hpp"

namespace pierce {

std::vector<float> star_clearance(const MeshView& mesh) {
    const auto at = [&](std::uint32_t v) { return to_double(mesh.positions[v]); };
    std::vector<Box> boxes(mesh.triangles.size);
    for (std::uint32_t t = 0; t < mesh.triangles.size; ++t)
        for (std::uint32_t v : mesh.triangles[t].vertex) boxes[t].extend(at(v));
    const BoxTree tree(std::move(boxes));
    const double rounding = constants::touch_tolerance * mesh.box.extent();

    std::vector<float> clearance(mesh.positions.size);
    for (std::uint32_t v = 0; v < mesh.positions.size; ++v) {
        double nearest = 0;
        for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i)
            nearest = std::max({nearest, length(at(mesh.corners[i].next) - at(v)),
                                length(at(mesh.corners[i].previous) - at(v))});
        Box region;
        region.extend(at(v));
        tree.for_each_in(region.inflated(nearest), [&](std::uint32_t t) {
            const auto& [corner] = mesh.triangles[t];
            if (corner[0] == v || corner[1] == v || corner[2] == v) return;
            const Vec3d closest = closest_on_triangle(at(v), at(corner[0]), at(corner[1]),
                                                      at(corner[2]));
            nearest = std::min(nearest, length(closest - at(v)));
        });
        clearance[v] = round_down(std::max(nearest - rounding, 0.0));
    }
    return clearance;
}

}  // namespace pierce
