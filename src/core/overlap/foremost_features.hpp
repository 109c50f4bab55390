#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "core/mesh_build/mesh_topology.hpp"
#include "core/overlap/moving_surface.hpp"
#include "pierce/vec3.hpp"

/// Which vertices and edges of a surface come first where they go.
namespace pierce {

/// The corners of every vertex of a surface.
struct VertexCorners {
    std::vector<std::uint32_t> begin;
    std::vector<Corner> corners;

    explicit VertexCorners(const MovingSurface& surface) {
        std::tie(begin, corners) = corners_by_vertex(surface.triangles, surface.points.size());
    }
    std::span<const Corner> of(std::uint32_t vertex) const {
        return std::span(corners).subspan(begin[vertex], begin[vertex + 1] - begin[vertex]);
    }
};

/// True if no triangle around the vertex reaches further against the way `outward`, which a face
/// has that meets it, by more than `skin` [length]. Otherwise the face only passes over it with its
/// border, as the front of what slides over a floor passes over the floor's vertices.
inline bool is_foremost(const MovingSurface& of, const VertexCorners& around, std::uint32_t vertex,
                        double time, Vec3d outward, double skin) {
    const Vec3d at = at_time(of.points[vertex], time), n = normalized(outward);
    const auto is_behind = [&](std::uint32_t u) {
        return -dot(n, at_time(of.points[u], time) - at) <= skin;
    };
    return std::ranges::all_of(around.of(vertex), [&](const Corner& c) {
        return is_behind(c.next) && is_behind(c.previous);
    });
}

/// True if no triangle at the edge reaches further along the way `n` than the edge, by more than
/// `skin` [length].
inline bool is_foremost_edge(const MovingSurface& of, const VertexCorners& around,
                             std::uint32_t from, std::uint32_t to, double time, Vec3d n,
                             double skin) {
    const Vec3d at = at_time(of.points[from], time);
    const auto is_behind = [&](std::uint32_t u) {
        return dot(n, at_time(of.points[u], time) - at) <= skin;
    };
    return std::ranges::all_of(around.of(from), [&](const Corner& c) {
        return (c.next != to || is_behind(c.previous)) && (c.previous != to || is_behind(c.next));
    });
}

}  // namespace pierce
