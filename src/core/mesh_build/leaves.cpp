#include "core/mesh_build/leaves.hpp"

#include <algorithm>

#include "core/mesh/half_edges.hpp"
#include "core/trace/bvh/forest.hpp"
#include "pierce/min_max.hpp"

namespace pierce::bvh {
namespace {

using Sides = std::span<const HalfEdge>;

/// Two triangles at an edge.
struct Couple {
    float area;  ///< half the area of their common box
    Sides sides;
};

}  // namespace

std::vector<Leaf> leaves_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                            const HalfEdges& sides_of_all, std::span<const std::uint32_t> partner) {
    const auto box_of = [&](const Triangle& t) {
        return box_around(positions[t.vertex[0]], positions[t.vertex[1]], positions[t.vertex[2]]);
    };
    std::vector<Sides> couple_of(triangles.size());
    const auto is_alone = [&](std::uint32_t t) { return couple_of[t].empty(); };
    const auto join_couple = [&](Sides sides) {
        couple_of[sides[0].triangle] = couple_of[sides[1].triangle] = sides;
    };
    std::vector<Couple> couples;
    couples.reserve(partner.empty() ? 3 * triangles.size() / 2 : 0);
    sides_of_all.for_each_edge([&](Sides sides) {
        if (sides.size() != 2 || sides[0].triangle == sides[1].triangle) return;
        const std::uint32_t t = sides[0].triangle, other = sides[1].triangle;
        if (!partner.empty() && (partner[t] != no_triangle || partner[other] != no_triangle)) {
            if (partner[t] == other && is_alone(t)) join_couple(sides);
            return;
        }
        const float area = join(box_of(triangles[t]), box_of(triangles[other])).half_area();
        couples.push_back({min_of(area, INFINITY), sides});  // infinite also for NaN
    });
    std::ranges::sort(couples, [](const Couple& c, const Couple& other) {
        return c.area != other.area ? c.area < other.area : c.sides.data() < other.sides.data();
    });
    for (const Couple& couple : couples)
        if (is_alone(couple.sides[0].triangle) && is_alone(couple.sides[1].triangle))
            join_couple(couple.sides);

    std::vector<Leaf> leaves;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const Triangle& alone = triangles[t];
        Leaf leaf{{alone.vertex[0], alone.vertex[1], alone.vertex[2], alone.vertex[0]},
                  {t, no_triangle}};
        if (!is_alone(t)) {
            const HalfEdge &side = couple_of[t][0], &other = couple_of[t][1];
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
