#pragma once

#include <cstdint>
#include <vector>

#include "pierce/inside.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// A mesh that was repaired.
struct FixedMesh {
    MeshData mesh;
    std::vector<std::uint32_t> vertices;  ///< per vertex, its place in the given mesh
    MeshInside done;                      ///< what was done, and whether there is an inside now
};

/// Repairs a mesh that is not closed: joins vertices at the same position, leaves out vertices
/// without triangles, triangles without three vertices and doubles, turns triangles to face one
/// way, and closes holes. A closed mesh loses vertices without triangles only. A mesh that
/// Inside::automatic gives an inside becomes closed: the result is the surface that detection uses
/// of the given mesh. Of others only small holes are closed (constants::small_cap). Positions stay
/// as they are. Throws InputError as Mesh does.
FixedMesh fix_mesh(const MeshData& mesh);

}  // namespace pierce
