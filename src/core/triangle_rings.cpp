#include "pierce/core/triangle_rings.hpp"

#include <algorithm>
#include <numbers>

#include "pierce/core/bvh/box_tree.hpp"
#include "pierce/core/closest_point.hpp"
#include "pierce/core/triangle.hpp"

namespace pierce {

std::vector<Neighbors> neighbors_of(std::span<const Triangle> triangles) {
    struct HalfEdge {
        std::uint64_t edge;
        std::uint32_t triangle;
        int opposite;
    };
    std::vector<HalfEdge> half_edges;
    half_edges.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const std::uint64_t a = triangles[t].vertex[(k + 1) % 3], b = triangles[t].vertex[(k + 2) % 3];
            half_edges.push_back({std::min(a, b) << 32 | std::max(a, b), t, k});
        }
    std::ranges::sort(half_edges, {}, &HalfEdge::edge);
    std::vector<Neighbors> neighbors(triangles.size());
    for (std::size_t i = 0; i < half_edges.size();) {
        std::size_t end = i;
        while (end < half_edges.size() && half_edges[end].edge == half_edges[i].edge) ++end;
        if (end - i == 2) {
            neighbors[half_edges[i].triangle].across[half_edges[i].opposite] = half_edges[i + 1].triangle;
            neighbors[half_edges[i + 1].triangle].across[half_edges[i + 1].opposite] = half_edges[i].triangle;
        }
        i = end;
    }
    return neighbors;
}

namespace {

bool touches(const Triangle& t, const Triangle& other) {
    return std::ranges::any_of(t.vertex, [&](std::uint32_t v) { return std::ranges::find(other.vertex, v) != std::end(other.vertex); });
}

/// True if the triangles around `v` form one closed fan that, seen along `axis`, goes once around it.
bool goes_around_once(const MeshView& mesh, std::uint32_t v, Vec3d axis) {
    const Corner* corner = mesh.corners.data + mesh.corner_offsets[v];
    const std::uint32_t count = mesh.corner_offsets[v + 1] - mesh.corner_offsets[v];
    std::uint32_t next = corner[0].previous, seen = 1;
    while (next != corner[0].next && seen < count) {
        const Corner* found = std::find_if(corner, corner + count, [&](const Corner& c) { return c.next == next; });
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

}  // namespace

std::vector<TriangleRing> rings_of(const MeshView& mesh) {
    const auto at = [&](std::uint32_t v) { return to_double(mesh.positions[v]); };
    const auto corner = [&](std::uint32_t t, int k) { return at(mesh.triangles[t].vertex[k]); };
    std::vector<Box> boxes(mesh.triangles.size);
    for (std::uint32_t t = 0; t < mesh.triangles.size; ++t)
        for (int k = 0; k < 3; ++k) boxes[t].extend(corner(t, k));
    const BoxTree tree(std::move(boxes));
    const double rounding = constants::touch_tolerance * mesh.box.extent();

    std::vector<TriangleRing> rings(mesh.triangles.size);
    for (std::uint32_t t = 0; t < mesh.triangles.size; ++t) {
        TriangleRing& ring = rings[t];
        const Vec3d center = (1.0 / 3) * (corner(t, 0) + corner(t, 1) + corner(t, 2));

        // The cone around the ring's normals, and where the rest of the surface begins.
        Vec3d sum;
        double reach = 0;
        std::vector<Vec3d> normals;
        bool sound = true;
        for (std::uint32_t v : mesh.triangles[t].vertex)
            for (std::uint32_t i = mesh.corner_offsets[v]; i < mesh.corner_offsets[v + 1]; ++i) {
                const Vec3d a = at(mesh.corners[i].next), b = at(mesh.corners[i].previous);
                sound &= !is_degenerate(at(v), a, b);
                normals.push_back(normalized(cross(a - at(v), b - at(v))));
                sum += normals.back();
                reach = std::max({reach, length(a - center), length(b - center)});
            }
        Box region;
        region.extend(center);
        tree.for_each_in(region.inflated(reach), [&](std::uint32_t other) {
            if (touches(mesh.triangles[t], mesh.triangles[other])) return;
            const Vec3d closest = closest_on_triangle(center, corner(other, 0), corner(other, 1), corner(other, 2));
            reach = std::min(reach, length(closest - center));
        });
        ring.reach = round_down(std::max(reach - rounding, 0.0));

        const Vec3d axis = normalized(sum);
        double cosine = 1;
        for (Vec3d n : normals) cosine = std::min(cosine, dot(axis, n));
        sound &= cosine > 0;
        for (std::uint32_t v : mesh.triangles[t].vertex) sound = sound && goes_around_once(mesh, v, axis);
        if (!sound) continue;
        ring.axis = to_float(axis);
        // Rounded up, so that a direction inside it faces every triangle of the ring for certain.
        ring.sine = static_cast<float>(std::sqrt(1 - std::min(cosine * cosine, 1.0)) + constants::touch_tolerance);
    }
    return rings;
}

}  // namespace pierce
