#include "core/mesh_build/separating_patches.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/geometry/triangle.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "core/mesh_build/triangle_groups.hpp"
#include "core/mesh_build/winding_tree.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/ids.hpp"

namespace pierce {
namespace {

/// Directions spread over all of a sphere, in a spiral.
std::vector<Vec3d> directions() {
    std::vector<Vec3d> result;
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    for (std::uint32_t k = 0; k < constants::sight_lines; ++k) {
        const double z = 1 - (2 * k + 1.0) / constants::sight_lines, r = std::sqrt(1 - z * z);
        result.push_back({r * std::cos(golden * k), r * std::sin(golden * k), z});
    }
    return result;
}

/// Tells which patches can be seen from far away.
class Sight {
public:
    Sight(std::span<const Vec3f> positions, std::span<const Triangle> triangles)
        : positions_(positions), triangles_(triangles), tree_(boxes()), directions_(directions()) {}

    /// True if a line leads out from the middle of the triangle.
    bool sees(std::uint32_t t) const {
        const Vec3d from = middle_of(positions_, triangles_[t]);
        return std::ranges::any_of(directions_, [&](Vec3d way) { return is_free(from, way, t); });
    }

private:
    std::vector<Box> boxes() const {
        std::vector<Box> result(triangles_.size());
        for (std::size_t t = 0; t < triangles_.size(); ++t)
            for (std::uint32_t v : triangles_[t].vertex) result[t].extend(to_double(positions_[v]));
        return result;
    }
    bool is_free(Vec3d from, Vec3d way, std::uint32_t own) const {
        const auto meets = [&](const Box& box) {
            double begin = 0, end = INFINITY;
            for (int k = 0; k < 3; ++k) {
                const double low = (box.lower[k] - from[k]) / way[k],
                             high = (box.upper[k] - from[k]) / way[k];
                begin = std::max(begin, std::min(low, high));
                end = std::min(end, std::max(low, high));
            }
            return begin <= end;
        };
        const ShearedRay ray{from, way};
        bool is_free = true;
        tree_.for_each_that([&](const Box& box) { return is_free && meets(box); },
                            [&](std::uint32_t t) {
                                const auto at = [&](int k) {
                                    return to_double(positions_[triangles_[t].vertex[k]]);
                                };
                                const Crossing crossing = cross_triangle(ray, at(0), at(1), at(2));
                                if (t != own && crossing && crossing.t > 0) is_free = false;
                            });
        return is_free;
    }

    std::span<const Vec3f> positions_;
    std::span<const Triangle> triangles_;
    BoxTree tree_;
    std::vector<Vec3d> directions_;
};

/// Judges patches by the winding number of some of them.
class PatchJudge {
public:
    PatchJudge(std::span<const Vec3f> positions, const OrientedTriangles& surface)
        : positions_(positions), surface_(surface), patches_(surface.patch, surface.patches) {}

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
        std::vector<bool> result;
        for (std::uint32_t p = 0; p < surface_.patches; ++p) {
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
            result.push_back(separates > (1 - constants::wall_share) * all);
        }
        return result;
    }

    std::vector<bool> seen() const {
        const Sight sight(positions_, surface_.triangles);
        std::vector<bool> result(surface_.patches, false);
        for (std::uint32_t p = 0; p < surface_.patches; ++p)
            patches_.for_each_sample(
                p, constants::wall_samples,
                [&](std::uint32_t t, std::uint32_t) { result[p] = result[p] || sight.sees(t); });
        return result;
    }

private:
    std::span<const Vec3f> positions_;
    const OrientedTriangles& surface_;
    TriangleGroups patches_;
};

}  // namespace

std::vector<bool> separating_patches(std::span<const Vec3f> positions,
                                     const OrientedTriangles& surface) {
    const PatchJudge judge(positions, surface);
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
