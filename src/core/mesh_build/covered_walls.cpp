#include "core/mesh_build/covered_walls.hpp"

#include <cstdint>
#include <utility>

#include "core/mesh_build/winding_tree.hpp"

namespace pierce {
namespace {

/// Two triangles between the same vertices that face each other.
using Twins = std::pair<std::uint32_t, std::uint32_t>;

/// The twins at one edge, each triangle at most once, in order of the triangles.
void find_twins(std::span<const Triangle> triangles, std::span<const HalfEdge> sides,
                std::vector<bool>& has_twin, std::vector<Twins>& twins) {
    const auto third = [&](const HalfEdge& side) {
        return triangles[side.triangle].vertex[side.opposite];
    };
    for (std::size_t i = 0; i < sides.size(); ++i)
        for (std::size_t j = i + 1; j < sides.size() && !has_twin[sides[i].triangle]; ++j) {
            if (has_twin[sides[j].triangle] || sides[i].forward == sides[j].forward ||
                third(sides[i]) != third(sides[j]))
                continue;
            has_twin[sides[i].triangle] = has_twin[sides[j].triangle] = true;
            twins.emplace_back(sides[i].triangle, sides[j].triangle);
        }
}

}  // namespace

void cover_walls(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                 const HalfEdges& sides, std::vector<Cover>& covered) {
    std::vector<bool> has_twin(triangles.size(), false);
    std::vector<Twins> twins;
    sides.for_each_edge([&](std::span<const HalfEdge> at_edge) {
        find_twins(triangles, at_edge, has_twin, twins);
    });
    if (twins.empty()) return;
    // Twins cancel each other, so the others alone decide on which side is what.
    std::vector<Triangle> others;
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        if (!has_twin[t]) others.push_back(triangles[t]);
    const WindingTree winding(positions, others);
    for (const auto& [one, other] : twins) {
        Vec3d sum;
        for (std::uint32_t v : triangles[one].vertex) sum += to_double(positions[v]);
        if (!(winding.at((1.0 / 3) * sum) > 0.5)) continue;
        covered.resize(triangles.size(), Cover::none);
        covered[one] = covered[other] = Cover::wholly;
    }
}

}  // namespace pierce
