#pragma once

#include <optional>
#include <vector>

#include "pierce/mesh.hpp"
#include "pierce/pose.hpp"

/// Detection by definition, in long double and with none of the library's code: Moeller-Trumbore
/// crossings of all triangles, sorted. For meshes and poses in general position; it says so when
/// they are not.
namespace pierce::test {

struct SolidVec {
    long double x, y, z;
};

/// A closed mesh placed in the world.
struct Solid {
    std::vector<SolidVec> positions;
    std::vector<Triangle> triangles;
};

SolidVec exact(Vec3d p);
Solid solid_of(const MeshData& mesh, const Pose& pose);

struct ExpectedContact {
    std::uint32_t vertex;
    std::uint32_t triangle;
    long double depth;
};

/// What the vertex rays of one body into another should find.
struct Expected {
    std::vector<ExpectedContact> contacts;
    std::vector<std::uint32_t> unclear;  ///< vertices whose answer hangs on rounding: a crossing at
                                         ///< an edge or at the start
};

/// Rules R1 to R3 for every vertex of `source` with the given inward directions.
Expected expected_contacts(const Solid& source, const std::vector<SolidVec>& inward,
                           const Solid& target);

/// What a body's inward rays should find where it is inside itself: vertices just outside of which
/// there is more of it, and whose ray leaves it, somewhere that is `away` or further from the
/// vertex at rest.
Expected expected_self_contacts(const Solid& body, const std::vector<SolidVec>& inward,
                                const Solid& rest, long double away);

/// Crossings of a segment with a solid strictly between its ends, leaving out `margin` of its
/// length at both; triangles around `excluded` do not count.
int crossings_between(SolidVec from, SolidVec to, const Solid& solid, std::uint32_t excluded,
                      long double margin);

/// True if the point is inside, by the winding number.
bool is_inside(SolidVec point, const Solid& solid);

}  // namespace pierce::test
