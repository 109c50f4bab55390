#include "core/mesh_build/triangle_rings.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

#include "core/geometry/closest_point.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/geometry/triangle_pair.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/box_tree.hpp"

namespace pierce {

std::vector<Neighbors> neighbors_of(std::span<const Triangle> triangles) {
    std::vector<Neighbors> neighbors(triangles.size());
    for_each_edge(triangles, [&](std::span<const HalfEdge> sides) {
        if (sides.size() != 2) return;
        neighbors[sides[0].triangle].across[sides[0].opposite] = sides[1].triangle;
        neighbors[sides[1].triangle].across[sides[1].opposite] = sides[0].triangle;
    });
    return neighbors;
}

namespace {

/// True if the triangles around `v` form one closed fan that, seen along `axis`, goes once around
/// it.
bool goes_around_once(const MeshView& mesh, std::uint32_t v, Vec3d axis) {
    const Corner* corner = mesh.corners.data + mesh.corner_offsets[v];
    const std::uint32_t count = mesh.corner_offsets[v + 1] - mesh.corner_offsets[v];
    std::uint32_t next = corner[0].previous, seen = 1;
    while (next != corner[0].next && seen < count) {
        const Corner* found = std::find_if(corner, corner + count,
                                           [&](const Corner& c) { return c.next == next; });
        if (found == corner + count) return false;
        next = found->previous;
        ++seen;
    }
    if (next != corner[0].next || seen != count) return false;

    double turn = 0;
    const Vec3d apex = to_double(mesh.positions[v]);
    const auto flat = [&](std::uint32_t u) {
        const Vec3d d = to_double(mesh.positions[u]) - apex;
        return d - dot(d, axis) * axis;
    };
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3d a = flat(corner[i].next), b = flat(corner[i].previous);
        turn += std::atan2(dot(cross(a, b), axis), dot(a, b));
    }
    return std::abs(turn - 2 * std::numbers::pi) < std::numbers::pi;
}

double triangle_distance(const Corners& a, const Corners& b) {
    if (edge_pierces(a, b, 0, 0) || edge_pierces(b, a, 0, 0)) return 0;
    double best = length(a[0] - closest_on_triangle(a[0], b[0], b[1], b[2]));
    for (int i = 0; i < 3; ++i) {
        best = std::min(best, length(a[i] - closest_on_triangle(a[i], b[0], b[1], b[2])));
        best = std::min(best, length(b[i] - closest_on_triangle(b[i], a[0], a[1], a[2])));
        for (int j = 0; j < 3; ++j)
            best = std::min(best, segment_distance(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]));
    }
    return best;
}

/// The openness between two triangles that share vertices: no point of `other` is closer to a point
/// Q of `own` than this times Q's distance to the border of `own`. At a shared edge, `other` lies
/// in a half plane. Its distance from Q is Q's distance to the edge, or that times the sine of the
/// dihedral angle. At a shared vertex, each triangle lies in a wedge. The openness is the distance
/// of unit vectors along the sides of one wedge from the other wedge.
double openness_towards(const MeshView& mesh, const Triangle& own, const Triangle& other) {
    const auto at = [&](std::uint32_t v) { return to_double(mesh.positions[v]); };
    std::vector<std::uint32_t> shared, own_rest, other_rest;
    for (std::uint32_t v : own.vertex)
        (std::ranges::find(other.vertex, v) != std::end(other.vertex) ? shared : own_rest)
            .push_back(v);
    for (std::uint32_t v : other.vertex)
        if (std::ranges::find(own.vertex, v) == std::end(own.vertex)) other_rest.push_back(v);
    if (shared.size() == 2)
        return fold_sine(at(shared[0]), at(shared[1]), at(own_rest[0]), at(other_rest[0]));
    if (shared.size() != 1) return 0;
    const Vec3d apex = at(shared[0]);
    const auto along = [&](std::uint32_t v) { return normalized(at(v) - apex); };
    double least = 1;
    for (int side = 0; side < 2; ++side) {
        const auto& from = side == 0 ? own_rest : other_rest;
        const auto& to = side == 0 ? other_rest : own_rest;
        for (std::uint32_t v : from) {
            const Vec3d closest = closest_on_triangle(along(v), {},
                                                      constants::wedge_length * along(to[0]),
                                                      constants::wedge_length * along(to[1]));
            least = std::min(least, length(along(v) - closest));
        }
    }
    return least;
}

Corners corners_of(const MeshView& mesh, std::uint32_t t) {
    return corners_of(mesh.positions, mesh.triangles[t]);
}

Vec3d center_of(const Corners& c) { return (1.0 / 3) * (c[0] + c[1] + c[2]); }

/// The triangles of the ring, each as often as it shares a vertex.
std::vector<Corners> ring_of(const MeshView& mesh, std::uint32_t t) {
    const auto at = [&](std::uint32_t v) { return to_double(mesh.positions[v]); };
    std::vector<Corners> ring;
    for (std::uint32_t v : mesh.triangles[t].vertex)
        for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i)
            ring.push_back({at(v), at(mesh.corners[i].next), at(mesh.corners[i].previous)});
    return ring;
}

/// The cone around the ring's normals, and by how much they may turn.
void measure_normals(const MeshView& mesh, std::uint32_t t, const std::vector<Corners>& triangles,
                     TriangleRing& ring) {
    Vec3d sum;
    std::vector<Vec3d> normals;
    double lowest = std::numeric_limits<double>::infinity();
    bool sound = true;
    for (const Corners& c : triangles) {
        const Vec3d normal = cross(c[1] - c[0], c[2] - c[0]);
        lowest = std::min(
            lowest, length(normal) /
                        std::max({length(c[1] - c[0]), length(c[2] - c[0]), length(c[2] - c[1])}));
        sound &= !is_degenerate(c[0], c[1], c[2]);
        normals.push_back(normalized(normal));
        sum += normals.back();
    }
    // Where vertices move by d, edges e and f each change by 2 d, and the normal e x f by 4 d
    // (longest + d) at most. The normal's length is longest times lowest. So the sine of its turn
    // is below 8 d / lowest while d is below the longest edge; beyond, 8 d / lowest is above 1.
    ring.tilt = round_up(8 / lowest);

    const Vec3d axis = normalized(sum);
    double cosine = 1;
    for (Vec3d n : normals) cosine = std::min(cosine, dot(axis, n));
    sound &= cosine > 0;
    for (std::uint32_t v : mesh.triangles[t].vertex)
        sound = sound && goes_around_once(mesh, v, axis);
    if (!sound) return;
    ring.axis = to_float(axis);
    // The sine is rounded up, so that a direction inside the cone faces every triangle of the ring
    // for certain.
    ring.sine = static_cast<float>(std::sqrt(1 - std::min(cosine * cosine, 1.0)) +
                                   constants::touch_tolerance);
}

}  // namespace

std::vector<TriangleRing> rings_of(const MeshView& mesh) {
    std::vector<Box> boxes(mesh.triangles.size);
    for (std::uint32_t t = 0; t < mesh.triangles.size; ++t)
        for (Vec3d p : corners_of(mesh, t)) boxes[t].extend(p);
    const BoxTree tree(boxes);
    const double rounding = constants::touch_tolerance * mesh.box.extent();

    std::vector<TriangleRing> rings(mesh.triangles.size);
    for (std::uint32_t t = 0; t < mesh.triangles.size; ++t) {
        TriangleRing& ring = rings[t];
        const Corners own = corners_of(mesh, t);
        const Vec3d center = center_of(own);
        const std::vector<Corners> triangles = ring_of(mesh, t);
        measure_normals(mesh, t, triangles, ring);
        for (int k = 0; k < 3; ++k) {
            const Vec3d edge = own[(k + 2) % 3] - own[(k + 1) % 3];
            ring.height[k] = round_down(length(cross(edge, own[k] - own[(k + 1) % 3])) /
                                        length(edge));
        }

        // The rest of the surface is looked for as far as the ring reaches.
        double gap = 0, radius = 0, openness = 1;
        for (Vec3d p : own) radius = std::max(radius, length(p - center));
        for (const Corners& c : triangles)
            for (Vec3d p : c) gap = std::max(gap, length(p - center));
        tree.for_each_in(boxes[t].inflated(gap), [&](std::uint32_t other) {
            if (other == t) return;
            const Corners its = corners_of(mesh, other);
            if (share_vertex(mesh.triangles[t], mesh.triangles[other])) {
                constexpr double inset = constants::touch_tolerance;
                const bool crosses = edge_pierces(own, its, inset, inset) ||
                                     edge_pierces(its, own, inset, inset);
                openness = crosses ? 0
                                   : std::min(openness, openness_towards(mesh, mesh.triangles[t],
                                                                         mesh.triangles[other]));
                return;
            }
            if (length(closest_on_triangle(center, its[0], its[1], its[2]) - center) - radius >=
                gap)
                return;
            gap = std::min(gap, triangle_distance(own, its));
        });
        ring.gap = round_down(std::max(gap - rounding, 0.0));
        ring.openness = static_cast<float>(std::max(openness - constants::touch_tolerance, 0.0));
    }
    return rings;
}

}  // namespace pierce
