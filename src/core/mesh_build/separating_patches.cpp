#include "core/mesh_build/separating_patches.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/mesh_build/sight.hpp"
#include "core/mesh_build/triangle_groups.hpp"
#include "core/mesh_build/winding_tree.hpp"
#include "pierce/constants.hpp"
#include "pierce/ids.hpp"

namespace pierce {
namespace {

/// Judges patches by the winding number of some of them.
class PatchJudge {
public:
    PatchJudge(std::span<const Vec3f> positions, const OrientedTriangles& surface, Workers& workers)
        : positions_(positions),
          surface_(surface),
          workers_(workers),
          patches_(surface.patch, surface.patches),
          is_open_(surface.open_patches(positions.size())) {}

    /// Which patches separate inside from outside, if those of `some` are the surface.
    std::vector<bool> separating(const std::vector<bool>& some) const {
        std::vector<Triangle> triangles;
        std::vector<std::uint32_t> place(surface_.triangles.size(), no_triangle);
        for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t) {
            if (!some[surface_.patch[t]]) continue;
            place[t] = static_cast<std::uint32_t>(triangles.size());
            triangles.push_back(surface_.triangles[t]);
        }
        const WindingTree winding(positions_, triangles);
        return for_each_open_patch([&](std::uint32_t p) {
            std::vector<Triangle> own;
            if (!some[p])
                for (std::uint32_t t : patches_.members(p)) own.push_back(surface_.triangles[t]);
            std::optional<WindingTree> of_patch;
            if (!own.empty()) of_patch.emplace(positions_, own);
            double all = 0, separates = 0;
            patches_.for_each_sample(
                p, constants::wall_samples, [&](std::uint32_t t, std::uint32_t place_in_patch) {
                    const Vec3d at = middle_of(positions_, surface_.triangles[t]);
                    double around = winding.at(at, place[t]);
                    if (of_patch) around += of_patch->at(at, place_in_patch);
                    const double area = area_of(positions_, surface_.triangles[t]);
                    all += area;
                    if (std::fabs(around - 0.5) < constants::surface_winding) separates += area;
                });
            return separates > (1 - constants::wall_share) * all;
        });
    }

    std::vector<bool> seen() const {
        const Sight sight(positions_, surface_.triangles);
        return for_each_open_patch([&](std::uint32_t p) {
            bool is_seen = false;
            patches_.for_each_sample(
                p, constants::wall_samples,
                [&](std::uint32_t t, std::uint32_t) { is_seen = is_seen || sight.from(t).any(); });
            return is_seen;
        });
    }

private:
    /// What judge(patch) says of open patches; true for others.
    template <class Judge>
    std::vector<bool> for_each_open_patch(const Judge& judge) const {
        return judge_groups("walls", surface_.patches, workers_,
                            [&](std::uint32_t p) { return !is_open_[p] || judge(p); });
    }

    std::span<const Vec3f> positions_;
    const OrientedTriangles& surface_;
    Workers& workers_;
    TriangleGroups patches_;
    std::vector<bool> is_open_;  ///< per patch
};

}  // namespace

std::vector<bool> separating_patches(std::span<const Vec3f> positions,
                                     const OrientedTriangles& surface, Workers& workers) {
    const PatchJudge judge(positions, surface, workers);
    std::vector<bool> now = judge.separating(std::vector<bool>(surface.patches, true));
    if (std::ranges::count(now, false) == 0) return now;
    now = judge.seen();
    for (std::uint32_t round = 0; round < constants::wall_rounds; ++round) {
        std::vector<bool> next = judge.separating(now);
        if (next == now) break;
        now = std::move(next);
    }
    return now;
}

}  // namespace pierce
