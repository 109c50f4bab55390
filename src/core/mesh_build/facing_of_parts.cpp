#include "core/mesh_build/facing_of_parts.hpp"

#include <cmath>

#include "core/mesh_build/triangle_groups.hpp"
#include "core/mesh_build/winding_tree.hpp"
#include "pierce/constants.hpp"

namespace pierce {
namespace {

/// The volume of some triangles around their middle, for an area of 1: what they say themselves
/// about which way they face.
double relative_volume(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                       std::span<const std::uint32_t> some) {
    Vec3d middle;
    for (std::uint32_t t : some) middle += middle_of(positions, triangles[t]);
    middle = (1 / static_cast<double>(some.size())) * middle;
    double volume = 0, area = 0;
    for (std::uint32_t t : some) {
        const auto at = [&](int k) {
            return to_double(positions[triangles[t].vertex[k]]) - middle;
        };
        volume += dot(at(0), cross(at(1), at(2))) / 6;
        area += area_of(positions, triangles[t]);
    }
    return area > 0 ? volume / (area * std::sqrt(area)) : 0;
}

}  // namespace

std::vector<Facing> facing_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                              const ConnectedParts& parts, Workers& workers) {
    const TriangleGroups groups(parts.part, parts.count);
    if (parts.count == 0) return {};
    if (parts.count == 1) {
        const double volume = relative_volume(positions, triangles, groups.members(0));
        return {volume < 0 ? Facing::inward : Facing::outward};
    }
    const WindingTree winding(positions, triangles);
    const auto facing = [&](std::uint32_t part) {
        const double volume = relative_volume(positions, triangles, groups.members(part));
        if (!(std::fabs(volume) > constants::flat_part)) return Facing::outward;
        double all = 0, within = 0, within_inward = 0;
        groups.for_each_sample(part, constants::wall_samples, [&](std::uint32_t t, std::uint32_t) {
            const double area = area_of(positions, triangles[t]);
            for (const Vec3d at : places_of(positions, triangles[t])) {
                // The part itself counts as 1/2, or as -1/2 if it faces inward.
                const double others = winding.at(at, t) + (volume < 0 ? 0.5 : -0.5);
                all += area;
                if (std::fabs(others) > 0.5) within += area;
                if (others < -0.5) within_inward += area;
            }
        });
        if (volume < 0 && !(within > constants::wall_share * all)) return Facing::inward;
        if (volume > 0 && within_inward > constants::wall_share * all) return Facing::in_inward;
        return Facing::outward;
    };
    return judge_groups("facing", parts.count, workers, facing);
}

}  // namespace pierce
