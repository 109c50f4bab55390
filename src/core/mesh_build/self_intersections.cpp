#include "core/mesh_build/self_intersections.hpp"

#include <algorithm>

#include "core/device/view.hpp"
#include "core/geometry/triangle_pair.hpp"
#include "core/mesh/coincident_vertices.hpp"
#include "core/mesh_build/box_tree.hpp"

namespace pierce {
namespace {

/// The triangles with every vertex replaced by the first one at its position.
std::vector<Triangle> welded(const MeshData& mesh) {
    const std::vector<std::uint32_t> first = first_at_position(mesh.positions);
    std::vector<Triangle> triangles = mesh.triangles;
    for (Triangle& t : triangles)
        for (std::uint32_t& v : t.vertex) v = first[v];
    return triangles;
}

std::uint32_t corner_not_in(const Triangle& t, const Triangle& other) {
    return *std::ranges::find_if(t.vertex, [&](std::uint32_t v) {
        return std::ranges::find(other.vertex, v) == std::end(other.vertex);
    });
}

/// True if two triangles with two common vertices lie on the same side of their common edge, in one
/// plane.
bool folded(View<const Vec3f> positions, const Triangle& t, const Triangle& other) {
    const auto at = [&](std::uint32_t v) { return to_double(positions[v]); };
    const std::uint32_t own = corner_not_in(t, other);
    std::uint32_t edge[2], size = 0;
    for (std::uint32_t v : t.vertex)
        if (v != own) edge[size++] = v;
    return fold_sine(at(edge[0]), at(edge[1]), at(own), at(corner_not_in(other, t))) <=
           constants::touch_tolerance;
}

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> self_intersections(const MeshData& mesh) {
    const std::vector<Triangle> triangles = welded(mesh);
    const View<const Vec3f> positions = view_of(mesh.positions);
    std::vector<Corners> corners;
    std::vector<Box> boxes(triangles.size());
    std::vector<bool> sound;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const Corners& c = corners.emplace_back(corners_of(positions, triangles[t]));
        for (Vec3d p : c) boxes[t].extend(p);
        sound.push_back(!is_degenerate(c[0], c[1], c[2]));
    }
    const BoxTree tree(boxes);

    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (!sound[t]) continue;
        tree.for_each_in(boxes[t], [&](std::uint32_t other) {
            if (other <= t || !sound[other]) return;
            const auto common = std::ranges::count_if(triangles[t].vertex, [&](std::uint32_t v) {
                return std::ranges::find(triangles[other].vertex, v) !=
                       std::end(triangles[other].vertex);
            });
            const bool meet = common == 3   ? true
                              : common == 2 ? folded(positions, triangles[t], triangles[other])
                                            : triangles_cross(corners[t], corners[other]);
            if (meet) pairs.emplace_back(t, other);
        });
    }
    std::ranges::sort(pairs);
    return pairs;
}

}  // namespace pierce
