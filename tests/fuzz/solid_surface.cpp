#include "fuzz/solid_surface.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/mesh/mesh_view.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"

namespace pierce::fuzz {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 exact(Vec3d p) { return {p.x, p.y, p.z}; }

Kernel::Triangle_3 face(const SolidSurface& s, std::size_t t, Vec3d shift = {}) {
    const auto& v = s.triangles[t].vertex;
    return {exact(s.points[v[0]] + shift), exact(s.points[v[1]] + shift),
            exact(s.points[v[2]] + shift)};
}

Box box_of(const SolidSurface& s, std::size_t t) {
    Box box;
    for (std::uint32_t v : s.triangles[t].vertex) box.extend(s.points[v]);
    return box;
}

int shared_corners(const Triangle& a, const Triangle& b) {
    int shared = 0;
    for (std::uint32_t v : a.vertex) shared += has_vertex(b, v);
    return shared;
}

/// True if two triangles meet in more than the corners they share.
bool meet_elsewhere(const SolidSurface& s, std::size_t i, std::size_t j) {
    const Kernel::Triangle_3 a = face(s, i), b = face(s, j);
    const auto point = [&](std::uint32_t v) { return exact(s.points[v]); };
    const Triangle &t = s.triangles[i], &u = s.triangles[j];
    const int shared = shared_corners(t, u);
    if (shared == 0) return CGAL::do_intersect(a, b);
    if (shared == 3) return true;
    if (shared == 1) {
        const auto opposite = [&](const Triangle& x, const Triangle& other) {
            for (int k = 0; k < 3; ++k)
                if (has_vertex(other, x.vertex[k]))
                    return Kernel::Segment_3(point(x.vertex[(k + 1) % 3]),
                                             point(x.vertex[(k + 2) % 3]));
            return Kernel::Segment_3();
        };
        return CGAL::do_intersect(opposite(t, u), b) || CGAL::do_intersect(opposite(u, t), a);
    }
    for (std::uint32_t v : u.vertex) {
        if (has_vertex(t, v)) continue;
        if (CGAL::orientation(a[0], a[1], a[2], point(v)) != CGAL::COPLANAR) return false;
        // Folded flat: the corners that are not shared are on one side of the shared edge.
        for (int k = 0; k < 3; ++k)
            if (!has_vertex(u, t.vertex[k]))
                return CGAL::coplanar_orientation(point(t.vertex[(k + 1) % 3]),
                                                  point(t.vertex[(k + 2) % 3]), point(t.vertex[k]),
                                                  point(v)) != CGAL::NEGATIVE;
    }
    return false;
}

}  // namespace

double SolidSurface::distance(Vec3d p) const {
    double squared = HUGE_VAL;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const Kernel::Triangle_3 f = face(*this, t);
        if (!f.is_degenerate()) squared = std::min(squared, CGAL::squared_distance(exact(p), f));
    }
    return std::sqrt(squared);
}

double SolidSurface::winding(Vec3d p) const {
    double sum = 0;
    for (const Triangle& t : triangles) {
        const Vec3d a = points[t.vertex[0]] - p, b = points[t.vertex[1]] - p,
                    c = points[t.vertex[2]] - p;
        const double x = length(a), y = length(b), z = length(c);
        sum += 2 * std::atan2(dot(a, cross(b, c)),
                              x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y);
    }
    return sum / (4 * std::numbers::pi);
}

bool SolidSurface::meets(const SolidSurface& other, Vec3d shift) const {
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (std::size_t j = 0; j < other.triangles.size(); ++j)
            if (CGAL::do_intersect(face(*this, i), face(other, j, shift))) return true;
    return false;
}

bool SolidSurface::has_plane_along(Vec3d from, Vec3d to, double touch) const {
    Box box;
    for (const Vec3d& p : points) box.extend(p);
    const double rounding = 1e-10 * (box.extent() + touch);
    return std::ranges::any_of(triangles, [&](const Triangle& t) {
        const Vec3d a = points[t.vertex[0]], b = points[t.vertex[1]], c = points[t.vertex[2]];
        const Vec3d n = normalized(cross(b - a, c - a));
        return std::fabs(dot(n, from - a)) < rounding && std::fabs(dot(n, to - a)) < rounding;
    });
}

std::vector<Vec3d> SolidSurface::outward_directions() const {
    std::vector<Vec3d> normals(points.size());
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const Vec3d p = points[t.vertex[k]], u = points[t.vertex[(k + 1) % 3]] - p,
                        v = points[t.vertex[(k + 2) % 3]] - p;
            normals[t.vertex[k]] += std::atan2(length(cross(u, v)), dot(u, v)) *
                                    normalized(cross(u, v));
        }
    for (Vec3d& n : normals) n = normalized(n);
    return normals;
}

bool SolidSurface::has_area() const {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (face(*this, i).is_degenerate()) return false;
        const auto& v = triangles[i].vertex;
        const Vec3d n = cross(points[v[1]] - points[v[0]], points[v[2]] - points[v[0]]);
        const double longest = std::max({length_squared(points[v[1]] - points[v[0]]),
                                         length_squared(points[v[2]] - points[v[1]]),
                                         length_squared(points[v[0]] - points[v[2]])});
        if (length(n) <= 16 * constants::degenerate_area * longest) return false;
    }
    return true;
}

bool SolidSurface::is_proper(double touch) const {
    if (!is_manifold(triangles) || !has_area()) return false;
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (std::size_t j = i + 1; j < triangles.size(); ++j)
            if (overlap(box_of(*this, i), box_of(*this, j)) && meet_elsewhere(*this, i, j))
                return false;
    for (const Triangle& t : triangles) {
        const auto& v = t.vertex;
        const Vec3d middle = (1.0 / 3) * (points[v[0]] + points[v[1]] + points[v[2]]);
        const Vec3d n = normalized(cross(points[v[1]] - points[v[0]], points[v[2]] - points[v[0]]));
        const Vec3d step = 8 * touch * n;
        if (std::fabs(winding(middle + step)) > 0.1 || std::fabs(winding(middle - step) - 1) > 0.1)
            return false;
    }
    return true;
}

bool is_manifold(std::span<const Triangle> triangles) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> ways;
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t v = t.vertex[k], w = t.vertex[(k + 1) % 3];
            if (v == w || ++ways[{v, w}] > 1) return false;
        }
    return std::ranges::all_of(ways, [&](const auto& way) {
        return ways.contains({way.first.second, way.first.first});
    });
}

}  // namespace pierce::fuzz
