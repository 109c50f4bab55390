#include "core/mesh_build/star_clearance.hpp"

#include <algorithm>

#include "core/base/workers.hpp"
#include "core/device/bits.hpp"
#include "core/geometry/closest_point.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/mesh_view.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

constexpr std::uint32_t vertices_at_once = 256;  ///< of a thread

double longest_edge(const MeshView& mesh, std::uint32_t v) {
    const auto at = [&](std::uint32_t u) { return to_double(mesh.positions[u]); };
    double longest = 0;
    for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i)
        longest = std::max({longest, length(at(mesh.corners[i].next) - at(v)),
                            length(at(mesh.corners[i].previous) - at(v))});
    return longest;
}

double distance_to_rest(const MeshView& mesh, const BoxLevels& levels, std::uint32_t v,
                        double reach) {
    const auto at = [&](std::uint32_t u) { return to_double(mesh.positions[u]); };
    double nearest = reach;
    QuickBox region;
    region.extend(mesh.positions[v]);
    for_each_group(
        mesh.box_nodes, levels, region.inflated(not_below(static_cast<float>(nearest))),
        [&](std::uint32_t group, std::uint32_t mask) {
            for (; mask != 0; mask &= mask - 1) {
                const Triangle&
                    t = mesh.triangles[mesh.group_triangles[group * constants::group_size +
                                                            lowest_bit(mask)]];
                if (has_vertex(t, v)) continue;
                const Vec3d closest = closest_on_triangle(at(v), at(t.vertex[0]), at(t.vertex[1]),
                                                          at(t.vertex[2]));
                nearest = std::min(length(closest - at(v)), nearest);
            }
            return false;
        });
    return nearest;
}

}  // namespace

std::vector<float> star_clearance(const MeshView& mesh, Workers& workers,
                                  const MeshChange* change) {
    const BoxLevels levels(mesh.triangles.size);
    const double rounding = constants::touch_tolerance * mesh.box.extent();
    std::vector<float> clearance(mesh.positions.size);
    workers.share_out(
        "stars", mesh.positions.size, vertices_at_once,
        [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t v = begin; v < end; ++v) {
                const double reach = longest_edge(mesh, v);
                const auto known = change != nullptr ? change->star(mesh, v, reach + rounding)
                                                     : std::nullopt;
                clearance[v] = known
                                   ? *known
                                   : round_down(std::max(
                                         distance_to_rest(mesh, levels, v, reach) - rounding, 0.0));
            }
        });
    return clearance;
}

}  // namespace pierce
