#pragma once

#include <optional>
#include <span>

#include "pierce/contact.hpp"
#include "pierce/host_device.hpp"
#include "pierce/vec3.hpp"

namespace pierce {

/// A way to take two bodies apart by moving one of them, without a turn.
struct Parting {
    Vec3d direction;   ///< unit, world space: where body b goes, or body a against it; zero if
                       ///< nothing has to go
    double depth = 0;  ///< [length] how far

    PIERCE_HD Vec3d translation() const { return depth * direction; }
};

class Mesh;

/// True if the mesh is closed, in one piece, and convex up to the rounding of its positions: a
/// rigid body with it can always leave another such body by its World::parting(). Takes n log n for
/// n triangles.
bool is_convex(const Mesh& mesh);

/// The shortest translation of body b that takes the target point and the source point of each of
/// these contacts as far apart as it says: normal . translation >= -distance for all of them. All
/// contacts are of one pair; those of sheets with an unknown side say nothing. Nothing if no
/// translation does it: the bodies hold each other from opposite sides. Linear in the number of
/// contacts for nearly all inputs. The bodies may still overlap after the move; World::parting()
/// tells how far they have to go until they do not.
std::optional<Parting> least_translation(std::span<const Contact> contacts);

}  // namespace pierce
