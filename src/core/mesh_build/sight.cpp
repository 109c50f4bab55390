#include "core/mesh_build/sight.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/triangle.hpp"
#include "core/mesh_build/triangle_groups.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"

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

std::vector<Box> boxes_of(std::span<const Vec3f> positions, std::span<const Triangle> triangles) {
    std::vector<Box> boxes(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t v : triangles[t].vertex) boxes[t].extend(to_double(positions[v]));
    return boxes;
}

/// True if a ray comes to a box.
bool meets(const Box& box, Vec3d from, Vec3d way) {
    double begin = 0, end = INFINITY;
    for (int k = 0; k < 3; ++k) {
        const double low = (box.lower[k] - from[k]) / way[k],
                     high = (box.upper[k] - from[k]) / way[k];
        begin = std::max(begin, std::min(low, high));
        end = std::min(end, std::max(low, high));
    }
    return begin <= end;
}

}  // namespace

Sight::Sight(std::span<const Vec3f> positions, std::span<const Triangle> triangles)
    : positions_(positions),
      triangles_(triangles),
      tree_(boxes_of(positions, triangles)),
      directions_(directions()) {}

Sight::Lines Sight::from(std::uint32_t triangle) const {
    const auto at = [&](int k) { return to_double(positions_[triangles_[triangle].vertex[k]]); };
    const Vec3d normal = cross(at(1) - at(0), at(2) - at(0)),
                middle = middle_of(positions_, triangles_[triangle]);
    Lines lines;
    for (const Vec3d way : directions_)
        if (is_free(middle, way, triangle)) ++(dot(way, normal) > 0 ? lines.front : lines.back);
    return lines;
}

bool Sight::is_free(Vec3d from, Vec3d way, std::uint32_t own) const {
    const ShearedRay ray{from, way};
    bool is_free = true;
    tree_.for_each_that([&](const Box& box) { return is_free && meets(box, from, way); },
                        [&](std::uint32_t t) {
                            const auto at = [&](int k) {
                                return to_double(positions_[triangles_[t].vertex[k]]);
                            };
                            const Crossing crossing = cross_triangle(ray, at(0), at(1), at(2));
                            if (t != own && crossing && crossing.t > 0) is_free = false;
                        });
    return is_free;
}

}  // namespace pierce
