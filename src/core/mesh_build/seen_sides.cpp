#include "core/mesh_build/seen_sides.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/mesh_build/sight.hpp"
#include "core/mesh_build/triangle_groups.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

/// So many triangles are looked from in all. Where open patches are more, they are a cloud of
/// triangles rather than sides of a solid, and stay as they are.
constexpr std::uint32_t most_looks = 1 << 13;
/// The part of all lines by which more lead out behind a patch than in front of it, if it is to be
/// turned [1]. Of a side of a convex solid that faces inward, half of all do; of the wall of a
/// cavity, the few that a hole in an outer wall lets through.
constexpr double least_seen = 0.05;

}  // namespace

std::vector<bool> turn_seen_sides_outward(std::span<const Vec3f> positions,
                                          OrientedTriangles& surface, Workers& workers) {
    std::vector<bool> turned(surface.patches, false);
    if (surface.patches < 2) return turned;
    const std::vector<bool> is_open = surface.open_patches(positions.size());
    const auto open = static_cast<std::uint32_t>(std::ranges::count(is_open, true));
    if (open == 0 || open > most_looks) return turned;
    const std::uint32_t samples = std::min(constants::wall_samples, most_looks / open);
    const Sight sight(positions, surface.triangles);
    const TriangleGroups patches(surface.patch, surface.patches);
    const auto shows_its_back = [&](std::uint32_t p) {
        if (!is_open[p]) return false;
        double all = 0, front = 0, back = 0;
        patches.for_each_sample(p, samples, [&](std::uint32_t t, std::uint32_t) {
            const Sight::Lines lines = sight.from(t);
            const double area = area_of(positions, surface.triangles[t]);
            all += area * constants::sight_lines;
            front += area * lines.front;
            back += area * lines.back;
        });
        return back > front + least_seen * all;
    };
    turned = judge_groups("sides", surface.patches, workers, shows_its_back);
    for (std::uint32_t p = 0; p < surface.patches; ++p)
        if (turned[p])
            for (std::uint32_t t : patches.members(p)) surface.turn(t);
    return turned;
}

}  // namespace pierce
