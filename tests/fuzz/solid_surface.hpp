#pragma once

#include <span>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce::fuzz {

/// Triangles in space, asked by exact predicates.
struct SolidSurface {
    std::vector<Vec3d> points;
    std::vector<Triangle> triangles;

    /// To the nearest triangle that has an area.
    double distance(Vec3d p) const;
    /// How often the surface winds around a point that is not on it: the sum of solid angles (van
    /// Oosterom and Strackee 1983).
    double winding(Vec3d p) const;
    bool holds(Vec3d p) const { return winding(p) > 0.5; }

    /// True if a triangle shares a point with one of the other's, moved by `shift`.
    bool meets(const SolidSurface& other, Vec3d shift) const;
    /// True if the way from one point to the other lies in the plane of a triangle, within
    /// rounding: where it meets that face's border nobody can tell which side it is on. `touch`
    /// [length] as in is_proper().
    bool has_plane_along(Vec3d from, Vec3d to, double touch) const;
    /// Per vertex: the mean of the normals around it, by angles.
    std::vector<Vec3d> outward_directions() const;
    /// True if no triangle is so thin that it might never be hit.
    bool has_area() const;
    /// True if it is closed, does not meet itself, and faces outward everywhere. `touch` [length]:
    /// how close to the surface a point counts as on it.
    bool is_proper(double touch) const;
};

/// True if every edge has two triangles that run through it in opposite ways, and no triangle names
/// a vertex twice.
bool is_manifold(std::span<const Triangle> triangles);

}  // namespace pierce::fuzz
