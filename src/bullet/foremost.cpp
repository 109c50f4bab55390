#include "bullet/foremost.hpp"

#include <algorithm>
#include <span>

namespace pierce::bullet {
namespace {

/// The sine of the angle by which a surface may come closer from a vertex on: what is curved has
/// several contacts, and the floor in front of what slides over it has none.
constexpr double foremost_sine = 0.5;

std::span<const Corner> corners_at(const MeshView& mesh, std::uint32_t vertex) {
    const std::uint32_t begin = mesh.corner_offsets[vertex];
    return {mesh.corners.data + begin, mesh.corner_offsets[vertex + 1] - begin};
}

bool is_behind(const MeshView& mesh, std::uint32_t other, std::uint32_t vertex, Vec3d way) {
    const Vec3d edge = to_double(mesh.positions[other]) - to_double(mesh.positions[vertex]);
    return dot(way, edge) <= foremost_sine * length(edge);
}

}  // namespace

bool is_foremost(const MeshView& mesh, std::uint32_t vertex, Vec3d way) {
    return std::ranges::all_of(corners_at(mesh, vertex), [&](const Corner& c) {
        return is_behind(mesh, c.next, vertex, way) && is_behind(mesh, c.previous, vertex, way);
    });
}

bool is_foremost(const MeshView& mesh, std::uint32_t from, std::uint32_t to, Vec3d way) {
    return std::ranges::all_of(corners_at(mesh, from), [&](const Corner& c) {
        return (c.next != to || is_behind(mesh, c.previous, from, way)) &&
               (c.previous != to || is_behind(mesh, c.next, from, way));
    });
}

}  // namespace pierce::bullet
