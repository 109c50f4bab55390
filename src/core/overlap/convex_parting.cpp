#include "core/overlap/convex_parting.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <tuple>

#include "core/geometry/solid_angle.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/used_vertices.hpp"
#include "core/mesh_build/triangle_rings.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/parting.hpp"

namespace pierce {
namespace {

/// An edge of a convex surface and the outward normals of the two faces beside it. Seen from a
/// direction between these two, the edge is in front of everything else.
struct ConvexEdge {
    Vec3d point, normals[2], along;
};

struct ConvexSurface {
    std::vector<Vec3d> points;   ///< of triangles
    std::vector<Vec3d> normals;  ///< unit, outward, of faces
    std::vector<ConvexEdge> edges;
};

/// The corner of a triangle that lies opposite its longest side, and how far it is from that side.
struct Apex {
    std::uint8_t corner = 0;
    double height = 0;

    Apex(const std::vector<Vec3d>& points, const Triangle& t) {
        const auto side = [&](int k) {
            return points[t.vertex[(k + 2) % 3]] - points[t.vertex[(k + 1) % 3]];
        };
        for (std::uint8_t k = 1; k < 3; ++k)
            if (length_squared(side(k)) > length_squared(side(corner))) corner = k;
        const double longest = length(side(corner));
        if (longest > 0) height = length(cross(side(0), side(1))) / longest;
    }
};

/// Unit outward normals of triangles. One that is not higher than the tolerance lies on its longest
/// side, and has the normal of the triangle across that; if that is as thin, of another one beside
/// it. Zero where all around are thin.
std::vector<Vec3d> face_normals(const PlacedSurface& surface, const HalfEdges& sides_of_all,
                                double tolerance) {
    const auto& [points, triangles] = surface;
    std::vector<Vec3d> normals(triangles.size());
    std::vector<Apex> apexes;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        apexes.emplace_back(points, triangles[t]);
        if (!(apexes[t].height > tolerance)) continue;
        const Vec3d p = points[triangles[t].vertex[0]];
        normals[t] = normalized(
            cross(points[triangles[t].vertex[1]] - p, points[triangles[t].vertex[2]] - p));
    }
    const std::vector<Neighbors> neighbors = neighbors_of(triangles.size(), sides_of_all);
    for (const bool over_longest_side_only : {true, false}) {
        std::vector<std::uint32_t> known;
        for (std::uint32_t t = 0; t < triangles.size(); ++t)
            if (length_squared(normals[t]) > 0) known.push_back(t);
        for (std::size_t next = 0; next < known.size(); ++next)
            for (const std::uint32_t t : neighbors[known[next]].across) {
                if (t == no_triangle || length_squared(normals[t]) > 0) continue;
                if (over_longest_side_only && neighbors[t].across[apexes[t].corner] != known[next])
                    continue;
                normals[t] = normals[known[next]];
                known.push_back(t);
            }
    }
    return normals;
}

/// The plane of a triangle with its normal, which may be borrowed.
struct FacePlane {
    Vec3d point, normal;
    double height = 0, tolerance = 0;  ///< [length] of the triangle, and of its corners

    /// True unless `p` is above the plane for certain: the less high a triangle is, the more does
    /// the rounding of its corners tilt it. A borrowed normal is not tilted.
    bool is_below(Vec3d p) const {
        const double away = length(p - point),
                     tilt = height > tolerance ? away / (rounding_share * height) : 0;
        return dot(normal, p - point) <= tolerance * (1 + tilt);
    }

private:
    static constexpr double rounding_share = 8;  ///< the tolerance is so many times the rounding
};

/// True if a closed surface winds once around the mean of some points.
bool winds_once(const PlacedSurface& surface, const std::vector<Vec3d>& points) {
    Vec3d middle;
    for (const Vec3d p : points) middle += p;
    middle = (1 / static_cast<double>(points.size())) * middle;
    double angle = 0;
    for (const Triangle& t : surface.triangles) {
        const auto corner = [&](int k) { return surface.points[t.vertex[k]] - middle; };
        angle += solid_angle(corner(0), corner(1), corner(2));
    }
    return std::lround(angle / (4 * std::numbers::pi)) == 1;
}

/// Nothing if the surface is open, or not convex by more than the rounding of its positions.
/// A closed surface is convex if it is at each edge, in one piece, so that it has two vertices and
/// faces more than edges (Euler), and winds around its inside once, which a star may not.
std::optional<ConvexSurface> convex_surface(const PlacedSurface& surface) {
    const auto& points = surface.points;
    const auto& triangles = surface.triangles;
    ConvexSurface convex;
    const std::vector<bool> is_used = used_vertices(triangles, points.size());
    Box box;
    for (std::size_t v = 0; v < points.size(); ++v)
        if (is_used[v]) {
            box.extend(points[v]);
            convex.points.push_back(points[v]);
        }
    // A deforming body's positions are float32 in world space.
    const double furthest = std::max(length(box.lower), length(box.upper)),
                 tolerance = constants::touch_tolerance * box.extent() +
                             std::numeric_limits<float>::epsilon() * furthest;
    const HalfEdges sides_of_all(triangles, points.size());
    std::vector<Vec3d> normals = face_normals(surface, sides_of_all, tolerance);
    if (std::ranges::any_of(normals, [](Vec3d n) { return length_squared(n) == 0; }))
        return std::nullopt;
    const auto plane = [&](std::size_t t) {
        return FacePlane{.point = points[triangles[t].vertex[0]],
                         .normal = normals[t],
                         .height = Apex(points, triangles[t]).height,
                         .tolerance = tolerance};
    };
    bool is_convex = true;
    std::size_t edges = 0;
    sides_of_all.for_each_edge([&](std::span<const HalfEdge> sides) {
        ++edges;
        is_convex = is_convex && sides.size() == 2 && is_balanced(sides);
        if (!is_convex) return;
        const Vec3d n = normals[sides[0].triangle], m = normals[sides[1].triangle];
        const auto opposite = [&](const HalfEdge& side) {
            return points[triangles[side.triangle].vertex[side.opposite]];
        };
        is_convex = plane(sides[0].triangle).is_below(opposite(sides[1])) &&
                    plane(sides[1].triangle).is_below(opposite(sides[0]));
        if (length(cross(n, m)) > constants::touch_tolerance)
            convex.edges.push_back({.point = points[sides[0].low],
                                    .normals = {n, m},
                                    .along = points[sides[0].high] - points[sides[0].low]});
    });
    if (!is_convex || convex.points.size() + triangles.size() != edges + 2 ||
        !winds_once(surface, convex.points))
        return std::nullopt;
    // Edges that are convex but for rounding may add up to a groove.
    if (static_cast<double>(convex.points.size()) * static_cast<double>(triangles.size()) <=
        static_cast<double>(constants::parting_products))
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            const FacePlane face = plane(t);
            if (face.height > tolerance &&
                !std::ranges::all_of(convex.points, [&](Vec3d p) { return face.is_below(p); }))
                return std::nullopt;
        }
    const auto less = [](Vec3d a, Vec3d b) {
        return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    };
    std::ranges::stable_sort(normals, less);
    const auto same = std::ranges::unique(normals,
                                          [](Vec3d a, Vec3d b) { return length(a - b) == 0; });
    normals.erase(same.begin(), same.end());
    convex.normals = std::move(normals);
    return convex;
}

/// How far the first points reach along `n` beyond where the second ones begin.
double reach_along(Vec3d n, const std::vector<Vec3d>& first, const std::vector<Vec3d>& second) {
    double high = -INFINITY, low = INFINITY;
    for (const Vec3d p : first) high = std::max(high, dot(n, p));
    for (const Vec3d p : second) low = std::min(low, dot(n, p));
    return high - low;
}

/// True if there is a direction seen from which an edge of the first surface is in front, and
/// against which one of the second is: the arcs of their normals cross on the sphere.
bool face_each_other(const ConvexEdge& first, const ConvexEdge& second) {
    const Vec3d a = first.normals[0], b = first.normals[1], c = -second.normals[0],
                d = -second.normals[1];
    const Vec3d ba = cross(b, a), dc = cross(d, c);
    const double cba = dot(c, ba), dba = dot(d, ba), adc = dot(a, dc), bdc = dot(b, dc);
    return cba * dba < 0 && adc * bdc < 0 && cba * bdc > 0;
}

/// The direction with the shortest way so far.
struct Shortest {
    Vec3d direction;
    double way = INFINITY;

    void offer(Vec3d along, double length) {
        if (length < way) *this = {along, length};
    }
};

}  // namespace

bool is_convex(const Mesh& mesh) {
    PlacedSurface surface{.points = {}, .triangles = mesh.triangles()};
    for (const Vec3f p : mesh.positions()) surface.points.push_back(to_double(p));
    return convex_surface(surface).has_value();
}

std::optional<Vec3d> shortest_convex_parting(const PlacedSurface& first,
                                             const PlacedSurface& second) {
    const auto product = [](std::size_t n, std::size_t m) {
        return static_cast<double>(n) * static_cast<double>(m);
    };
    const std::size_t points = first.points.size() + second.points.size();
    // A closed surface has three edges for every two triangles.
    if (product(points, first.triangles.size() + second.triangles.size()) +
            2.25 * product(first.triangles.size(), second.triangles.size()) >
        static_cast<double>(constants::parting_products))
        return std::nullopt;
    const auto a = convex_surface(first);
    const auto b = a ? convex_surface(second) : std::nullopt;
    if (!b) return std::nullopt;

    Shortest shortest;
    for (const Vec3d n : a->normals) shortest.offer(n, reach_along(n, a->points, b->points));
    for (const Vec3d n : b->normals) shortest.offer(-n, reach_along(-n, a->points, b->points));
    Shortest of_edges;
    for (const ConvexEdge& edge : a->edges)
        for (const ConvexEdge& other : b->edges) {
            if (!face_each_other(edge, other)) continue;
            const Vec3d n = cross(edge.along, other.along);
            if (length(n) == 0) continue;
            const Vec3d outward = normalized(dot(n, edge.normals[0] + edge.normals[1]) < 0 ? -n
                                                                                           : n);
            of_edges.offer(outward, dot(outward, edge.point - other.point));
        }
    if (of_edges.way < shortest.way)
        shortest.offer(of_edges.direction, reach_along(of_edges.direction, a->points, b->points));
    if (!(shortest.way > 0)) return std::nullopt;
    return shortest.way * shortest.direction;
}

}  // namespace pierce
