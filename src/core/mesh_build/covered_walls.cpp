#include "core/mesh_build/covered_walls.hpp"

#include <algorithm>
#include <cstdint>

#include "core/mesh_build/winding_tree.hpp"

namespace pierce {
namespace {

/// The twins at one edge, each triangle at most once, in order of the triangles.
void find_twins(std::span<const Triangle> triangles, std::span<const HalfEdge> sides,
                std::vector<bool>& has_twin, std::vector<Twins>& twins) {
    const auto third = [&](const HalfEdge& side) {
        return triangles[side.triangle].vertex[side.opposite];
    };
    if (sides.size() < 2 || (sides.size() == 2 && third(sides[0]) != third(sides[1]))) return;
    std::vector<HalfEdge> by_third(sides.begin(), sides.end());
    std::ranges::stable_sort(by_third, {}, third);
    for (auto first = by_third.begin(); first != by_third.end();) {
        const auto last = std::find_if(first, by_third.end(), [&](const HalfEdge& side) {
            return third(side) != third(*first);
        });
        // One way before the other, and then one of each at a time.
        const auto other = std::stable_partition(first, last,
                                                 [](const HalfEdge& side) { return side.forward; });
        auto one = first, twin = other;
        const auto skip_taken = [&](auto& at, auto end) {
            while (at != end && has_twin[at->triangle]) ++at;
            return at != end;
        };
        while (skip_taken(one, other) && skip_taken(twin, last)) {
            has_twin[one->triangle] = has_twin[twin->triangle] = true;
            twins.emplace_back(one->triangle, twin->triangle);
        }
        first = last;
    }
}

}  // namespace

std::vector<Twins> twins_of(std::span<const Triangle> triangles, const HalfEdges& sides) {
    std::vector<bool> has_twin(triangles.size(), false);
    std::vector<Twins> twins;
    sides.for_each_edge([&](std::span<const HalfEdge> at_edge) {
        find_twins(triangles, at_edge, has_twin, twins);
    });
    return twins;
}

void cover_walls(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                 std::span<const Twins> twins, std::vector<Cover>& covered) {
    if (twins.empty()) return;
    std::vector<bool> has_twin(triangles.size(), false);
    for (const auto& [one, other] : twins) has_twin[one] = has_twin[other] = true;
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
