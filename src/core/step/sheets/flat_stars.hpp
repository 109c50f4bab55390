#pragma once

#include "core/device/four.hpp"
#include "core/device/view.hpp"
#include "core/geometry/separating_direction.hpp"
#include "core/step/sheets/sheet_bounds.hpp"
#include "core/step/sheets/slab.hpp"
#include "pierce/min_max.hpp"

/// Where a sheet cannot fold onto itself.
namespace pierce::stages {

/// The corners of a placed triangle around which nothing folds; no_vertex for the others.
struct alignas(16) FlatCorners {
    std::uint32_t vertex[3] = {no_vertex, no_vertex, no_vertex};
    std::uint32_t padding = 0;

    /// True if another triangle of the same body shares such a vertex with this one.
    PIERCE_HD bool shares_one(const FlatCorners& other) const {
#if defined(PIERCE_FOUR_LANES)
        // The others go round, so that each meets each; the padding meets itself.
        const Four::Bits mine = Four::bits_at(vertex), others = Four::bits_at(other.vertex);
        const Four::Bits same = (mine == others) |
                                (mine == __builtin_shufflevector(others, others, 1, 2, 0, 3)) |
                                (mine == __builtin_shufflevector(others, others, 2, 0, 1, 3));
        constexpr auto nothing = static_cast<std::int32_t>(no_vertex);
        return (Four::sign_bits(same & (mine != nothing)) & 7) != 0;
#else
        bool shares = false;
        for (std::uint32_t v : vertex)
            shares |= v != no_vertex &&
                      (v == other.vertex[0] || v == other.vertex[1] || v == other.vertex[2]);
        return shares;
#endif
    }
};

/// Per vertex of a sheet: 1 if the triangles around it are proved not to meet during the step,
/// except where they hang together: they go around the vertex once, and each of them keeps facing
/// one common direction. Seen along that direction, they are sectors that share no more than their
/// sides at any time: a sector has less than half a turn while its triangle faces that way, and the
/// number of turns cannot change. Nothing folds there (Volino and Magnenat-Thalmann 1994). Nor are
/// features of such triangles without a common corner nearer than the thickness in the end: seen
/// so, the three heights of each triangle are not below that. So the end of a side is at least as
/// far from all sectors that it does not belong to, and the middle from all outer edges.
struct FindFlatStars {
    SheetBodies bodies;
    View<std::uint32_t> flat;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const OwnedItem item = owned_item(bodies.vertex_offsets, i);
        const SheetBody body = bodies[item.owner];
        flat[i] = body.view.collision.sheet && is_flat(body, item.index);
    }

private:
    /// A way, seen along one direction.
    struct Seen {
        double x, y;

        PIERCE_HD friend double cross(Seen u, Seen w) { return u.x * w.y - u.y * w.x; }
    };
    struct MovingSeen {
        Seen start, end;
    };

    /// Sees along the product of its two vectors: of any ways, `cross(seen u, seen w)` is
    /// `dot(cross(u, w), cross(x, y))`, whatever x and y are (Binet and Cauchy).
    struct Sight {
        Vec3d x, y;

        PIERCE_HD Seen operator()(Vec3d p) const { return {dot(x, p), dot(y, p)}; }
        PIERCE_HD MovingSeen operator()(const MovingPoint& p) const {
            return {(*this)(p.start), (*this)(p.end)};
        }
    };

    /// A lower bound of how a triangle at the vertex faces us over the step; the triangle is given
    /// by the ways to its two other corners. The bound is the least of the Bernstein coefficients
    /// of a quadratic, which is not above the quadratic's least value.
    PIERCE_HD static double facing(const MovingSeen& u, const MovingSeen& w) {
        const double middle = 0.5 * (cross(u.start, w.end) + cross(u.end, w.start));
        return min_of(cross(u.start, w.start), min_of(middle, cross(u.end, w.end)));
    }

    /// True if a height of a triangle, given by two of its sides, is below the thickness.
    PIERCE_HD static bool is_narrow(Seen u, Seen w, double thickness) {
        const auto squared = [](double x, double y) { return x * x + y * y; };
        const double area = cross(u, w),
                     longest = max_of(max_of(squared(u.x, u.y), squared(w.x, w.y)),
                                      squared(w.x - u.x, w.y - u.y));
        return !(area * area >= thickness * thickness * longest);
    }

    PIERCE_HD static bool is_flat(const SheetBody& body, std::uint32_t v) {
        const std::uint32_t begin = body.mesh.corner_offsets[v],
                            end = body.mesh.corner_offsets[v + 1];
        if (begin == end || body.mesh.fans[begin] == no_vertex) return false;
        const MovingPoint at = body.vertex(v);
        const auto way_to = [&](std::uint32_t place) {
            const MovingPoint p = body.vertex(body.mesh.fans[place]);
            return MovingPoint{p.start - at.start, p.end - at.end};
        };
        const MovingPoint last = way_to(end - 1);
        Vec3d n, before = last.start + last.end;
        double size = 0;
        for (std::uint32_t c = begin; c < end; ++c) {
            const MovingPoint w = way_to(c);
            const Vec3d twice_middle = w.start + w.end;
            n += cross(before, twice_middle);
            size = max_of(size, max_of(length_squared(w.start), length_squared(w.end)));
            before = twice_middle;
        }
        const SlabFrame frame(n);
        const Sight sight{frame.axis[1], frame.axis[2]};
        const double least = constants::motion_rounding * size,
                     thickness = body.view.collision.thickness;
        const MovingSeen first = sight(last);
        std::uint32_t turns = 0;
        MovingSeen u = first;
        for (std::uint32_t c = begin; c < end; ++c) {
            const MovingSeen w = sight(way_to(c));
            if (!(facing(u, w) > least) || is_narrow(u.end, w.end, thickness)) return false;
            turns += cross(u.start, first.start) >= 0 && cross(first.start, w.start) > 0;
            u = w;
        }
        return turns == 1;
    }
};

/// Per place of a group: its triangle's flat corners.
struct PlaceFlatCorners {
    SheetBodies bodies;
    View<const std::uint32_t> flat;  ///< per vertex
    View<FlatCorners> corners;

    PIERCE_HD void operator()(std::uint32_t i) const {
        FlatCorners c;
        const std::uint32_t owner = owned_item(bodies.block_offsets, i / triangles_per_block).owner;
        const SheetBody body = bodies[owner];
        if (body.has_triangle_at(i)) {
            const Triangle t = body.mesh.triangles[body.triangle_at(i)];
            for (int k = 0; k < 3; ++k)
                if (flat[bodies.vertex_offsets[owner] + t.vertex[k]]) c.vertex[k] = t.vertex[k];
        }
        write_whole(corners[i], c);
    }
};

}  // namespace pierce::stages
