#pragma once

#include <cmath>
#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/step/edges/edge_triangles.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/trace/first_crossing.hpp"
#include "pierce/constants.hpp"

/// What is around the place where an edge begins.
namespace pierce::stages {

/// What a clean crossing counts.
inline constexpr std::int64_t clean_crossing = 2 * constants::half_turn;

/// What the crossing of a line with a triangle counts: positive where it leads out.
PIERCE_HD inline std::int64_t signed_share(const ShearedRay& line, const TriangleCorners& at,
                                           const Crossing& crossing) {
    const std::int64_t share = crossing_share(line, at.a, at.b, at.c, crossing);
    return crossing.sign > 0 ? share : -share;
}

/// The triangle of the target with the smallest id through which an edge enters where it begins, if
/// it begins on the surface of `parts` parts, in which it is a touch tolerance further on: its
/// crossings within the tolerance lead into all of them. `ray` runs along the edge.
PIERCE_HD inline std::uint32_t entered_at_start(const BodyView& target,
                                                const EdgeTriangles& triangles, const Ray& ray,
                                                std::uint32_t parts) {
    const Surface surface = target.surface();
    const ShearedRay line(ray.origin, ray.direction);
    std::int64_t weight = 0;
    std::uint32_t entry = no_triangle;
    triangles.each([&](std::uint32_t t) {
        const TriangleCorners at = surface.corners(t);
        const Crossing crossing = cross_triangle(line, at.a, at.b, at.c);
        if (crossing.kind != Crossing::transversal || std::fabs(crossing.t) > ray.touch) return;
        weight += signed_share(line, at, crossing);
        if (!(crossing.sign > 0)) entry = min_of(t, entry);
    });
    return weight + (parts - 1) * clean_crossing <= -constants::crossing_weight ? entry
                                                                                : no_triangle;
}

/// How many parts of the target there are a touch tolerance behind the place where an edge begins:
/// how often a ray from there leaves one more than it enters. `ray` runs along the edge.
PIERCE_HD inline std::uint32_t parts_behind_start(const BodyView& target, const PlacedEdge& edge,
                                                  const Ray& ray) {
    const Surface surface = target.surface();
    const ShearedRay line(ray.origin, ray.direction);
    PlacedEdge beyond = edge;
    beyond.b = ray.origin + range_through(target, ray.origin) * ray.direction;
    std::int64_t weight = 0;
    for_each_group(
        target.box_nodes, BoxLevels(target.mesh.triangles.size),
        boxes_along(beyond, target, ray.touch), [&](std::uint32_t group, std::uint32_t mask) {
            for (; mask != 0; mask &= mask - 1) {
                const std::uint32_t t = target.mesh.group_triangles[group * constants::group_size +
                                                                    lowest_bit(mask)];
                const TriangleCorners at = surface.corners(t);
                const Crossing crossing = cross_triangle(line, at.a, at.b, at.c);
                if (crossing.kind != Crossing::transversal || !(crossing.t > ray.touch)) continue;
                weight += signed_share(line, at, crossing);
            }
            return false;
        });
    return weight > 0 ? static_cast<std::uint32_t>((weight + clean_crossing / 2) / clean_crossing)
                      : 0;
}

}  // namespace pierce::stages
