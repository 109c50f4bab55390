#include "core/mesh_build/leaves.hpp"

#include <algorithm>

#include "core/mesh/half_edges.hpp"
#include "core/trace/bvh/forest.hpp"
#include "pierce/min_max.hpp"

namespace pierce::bvh {
namespace {

/// Two triangles at an edge.
struct Couple {
    float area;  ///< half the area of their common box
    HalfEdge side[2];
};

}  // namespace

std::vector<Leaf> leaves_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                            const HalfEdges& sides_of_all) {
    const auto box_of = [&](const Triangle& t) {
        return box_around(positions[t.vertex[0]], positions[t.vertex[1]], positions[t.vertex[2]]);
    };
    std::vector<Couple> couples;
    couples.reserve(3 * triangles.size() / 2);
    sides_of_all.for_each_edge([&](std::span<const HalfEdge> sides) {
        if (sides.size() != 2 || sides[0].triangle == sides[1].triangle) return;
        const float area = join(box_of(triangles[sides[0].triangle]),
                                box_of(triangles[sides[1].triangle]))
                               .half_area();
        couples.push_back({min_of(area, INFINITY), {sides[0], sides[1]}});  // infinite also for NaN
    });
    std::ranges::stable_sort(couples, {}, &Couple::area);

    std::vector<const Couple*> couple_of(triangles.size(), nullptr);
    for (const Couple& couple : couples) {
        const Couple *&first = couple_of[couple.side[0].triangle],
                     *&second = couple_of[couple.side[1].triangle];
        if (first == nullptr && second == nullptr) first = second = &couple;
    }
    std::vector<Leaf> leaves;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const Triangle& alone = triangles[t];
        Leaf leaf{{alone.vertex[0], alone.vertex[1], alone.vertex[2], alone.vertex[0]},
                  {t, no_triangle}};
        if (const Couple* couple = couple_of[t]) {
            const HalfEdge &side = couple->side[0], &other = couple->side[1];
            if (side.triangle != t) continue;  // the couple is listed with its first triangle
            leaf = {{alone.vertex[side.opposite], side.low, side.high,
                     triangles[other.triangle].vertex[other.opposite]},
                    {t, other.triangle}};
        }
        leaves.push_back(leaf);
    }
    return leaves;
}

std::vector<Leaf> leaves_of(const MeshData& mesh) {
    return leaves_of(mesh.positions, mesh.triangles,
                     HalfEdges(mesh.triangles, mesh.positions.size()));
}

}  // namespace pierce::bvh
