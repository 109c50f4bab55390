#pragma once

#include <cstdint>
#include <functional>

#include "pierce/mesh.hpp"
#include "pierce/pose.hpp"

namespace pierce::scenes {

/// The mass properties of a solid of density 1 bounded by a closed mesh.
struct MassProperties {
    double mass = 0;  ///< the volume
    Vec3d center;
    Vec3d inertia;           ///< principal moments about the centre
    Matrix3 principal_axes;  ///< rows are the axes, right-handed
};

/// The volume that a mesh encloses with its vertices at other positions.
double volume_of(const MeshData& mesh, const std::function<Vec3d(std::uint32_t)>& position);

/// Integrates over the tetrahedra that the triangles span with the centroid. Throws InputError if
/// the volume is not positive.
MassProperties mass_properties(const MeshData& mesh);

/// Moves the centre of mass to the origin and the principal axes to x, y, z; returns how points of
/// the mesh moved.
Frame to_principal_frame(MeshData& mesh);

}  // namespace pierce::scenes
