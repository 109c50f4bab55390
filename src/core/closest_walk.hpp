#pragma once

#include "pierce/core/closest_point.hpp"
#include "pierce/core/constants.hpp"
#include "pierce/core/mesh.hpp"

namespace pierce {

/// A point of a surface and the triangle it lies in.
struct SurfacePoint {
    std::uint32_t triangle = no_triangle;
    Vec3d point;
};

/// A walk over a surface, from triangle to triangle, towards the point closest to `p`.
class ClosestWalk {
public:
    PIERCE_HD ClosestWalk(const MeshView& mesh, View<const Vec3f> positions, Vec3d p, std::uint32_t start)
        : mesh_(mesh), positions_(positions), p_(p) {
        best_ = {start, closest_in(start)};
        nearest_ = length_squared(best_.point - p_);
    }

    /// Goes on while a neighbour is closer, or until `max_triangles` were looked at; returns the closest point met. If the
    /// walk ended by itself no triangle across an edge is closer; it is never further from `p` than the start.
    PIERCE_HD SurfacePoint run(std::uint32_t max_triangles) {
        left_ = max_triangles;
        while (left_ > 0 && step()) {
        }
        return best_;
    }

private:
    PIERCE_HD Vec3d at(std::uint32_t v) const { return to_double(positions_[v]); }

    PIERCE_HD Vec3d closest_in(std::uint32_t triangle) const {
        const Triangle& t = mesh_.triangles[triangle];
        return closest_on_triangle(p_, at(t.vertex[0]), at(t.vertex[1]), at(t.vertex[2]));
    }

    PIERCE_HD bool try_triangle(std::uint32_t triangle) {
        --left_;
        const Vec3d point = closest_in(triangle);
        if (!(length_squared(point - p_) < nearest_)) return false;
        nearest_ = length_squared(point - p_);
        best_ = {triangle, point};
        return true;
    }

    /// From inside, the foot of the perpendicular in every facet of a round surface is closer than the points around it:
    /// so the neighbours are asked even if the closest point lies on no edge. If it is a vertex, so are all around it.
    PIERCE_HD bool step() {
        const std::uint32_t from = best_.triangle;
        const Triangle& t = mesh_.triangles[from];
        int edges = 0, off = 0;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t next = mesh_.neighbors[from].across[k];
            if (next != no_triangle && left_ > 0 && try_triangle(next)) return true;
            if (is_on(best_.point, at(t.vertex[(k + 1) % 3]), at(t.vertex[(k + 2) % 3])))
                ++edges;
            else
                off = k;
        }
        return edges == 2 && (turn(from, t.vertex[off], 1) || turn(from, t.vertex[off], 2));
    }

    /// Looks at the triangles around vertex `v` one after the other, starting across the corner `side` places after it.
    PIERCE_HD bool turn(std::uint32_t from, std::uint32_t v, int side) {
        for (std::uint32_t at = from; left_ > 0;) {
            const Triangle& t = mesh_.triangles[at];
            const int corner = t.vertex[0] == v ? 0 : t.vertex[1] == v ? 1 : 2;
            at = mesh_.neighbors[at].across[(corner + side) % 3];
            if (at == no_triangle || at == from || !has_vertex(mesh_.triangles[at], v)) return false;
            if (try_triangle(at)) return true;
        }
        return false;
    }

    /// True if `p` lies so close to the line from `a` to `b` that what is beyond it is worth a look.
    PIERCE_HD static bool is_on(Vec3d p, Vec3d a, Vec3d b) {
        const double size = length_squared(b - a);
        return length_squared(cross(b - a, p - a)) <= constants::touch_tolerance * size * size;
    }

    MeshView mesh_;
    View<const Vec3f> positions_;
    Vec3d p_;
    SurfacePoint best_;
    double nearest_ = 0;
    std::uint32_t left_ = 0;
};

}  // namespace pierce
