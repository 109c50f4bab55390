#include "core/overlap/moving_surface.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace pierce {

Box MovingSurface::box() const {
    Box around;
    for (const MovingPoint& p : points) {
        around.extend(p.start);
        around.extend(p.end);
    }
    return around;
}

std::vector<Vec3d> MovingSurface::normals(Vec3d MovingPoint::*at) const {
    std::vector<Vec3d> sums(points.size());
    for (const Triangle& t : triangles) {
        const Vec3d a = points[t.vertex[0]].*at;
        const Vec3d normal = cross(points[t.vertex[1]].*at - a, points[t.vertex[2]].*at - a);
        for (std::uint32_t v : t.vertex) sums[v] += normal;
    }
    return sums;
}

MovingSurface MovingSurface::inner(double depth) const {
    MovingSurface moved = *this;
    for (Vec3d MovingPoint::*at : {&MovingPoint::start, &MovingPoint::end}) {
        const std::vector<Vec3d> outward = normals(at);
        for (std::size_t v = 0; v < outward.size(); ++v)
            moved.points[v].*at -= depth * normalized(outward[v]);
    }
    return moved;
}

std::vector<std::uint8_t> MovingSurface::own_features() const {
    std::vector<std::uint8_t> own(triangles.size(), 0);
    std::vector<bool> seen(points.size(), false);
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (std::size_t t = 0; t < own.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t u = triangles[t].vertex[k], v = triangles[t].vertex[(k + 1) % 3];
            if (!seen[u]) own[t] |= static_cast<std::uint8_t>(1u << k);
            seen[u] = true;
            if (edges.emplace(std::min(u, v), std::max(u, v)).second)
                own[t] |= static_cast<std::uint8_t>(8u << k);
        }
    return own;
}

}  // namespace pierce
