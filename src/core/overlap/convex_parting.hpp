#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pierce/mesh.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// A surface where it is now.
struct PlacedSurface {
    std::vector<Vec3d> points;
    std::span<const Triangle> triangles;
};

/// The shortest translation of the second surface after which a plane is between the two. Nothing
/// unless both surfaces are closed and convex, and small enough to try all planes
/// (constants::parting_products). Each face of either surface gives a plane, and each pair of edges
/// that face each other (Gregorius, The Separating Axis Test between Convex Polyhedra, GDC 2013).
std::optional<Vec3d> shortest_convex_parting(const PlacedSurface& first,
                                             const PlacedSurface& second);

}  // namespace pierce
