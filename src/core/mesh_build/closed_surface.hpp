#pragma once

#include <cstdint>
#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh/surface.hpp"
#include "pierce/inside.hpp"
#include "pierce/mesh.hpp"

namespace pierce {

/// A surface between the vertices of a mesh; it is closed if it has an inside.
struct ClosedSurface {
    std::vector<Triangle> triangles;  ///< those of the mesh that are kept, in their order, and then
                                      ///< caps
    std::vector<std::uint32_t> given;  ///< per triangle, its id in the mesh; no_triangle for caps
    std::vector<Cover> covered;        ///< covered_triangles() of the surface
    MeshInside inside;
};

/// Makes a mesh that is not closed solid: joins vertices at the same position, turns triangles to
/// face one way, leaves out doubles and what lies within the solid, by the winding number, and
/// closes holes. With `rule` automatic, only meshes that are nearly closed get an inside, by
/// constants::caps_of_area and those that follow it; otherwise every mesh whose caps are smaller
/// than constants::largest_caps of the rest. If it gets none, there are no triangles.
ClosedSurface closed_surface(const MeshData& mesh, Inside rule, Workers& workers);

/// The surface of a mesh by a rule, and what is inside it. `sides`: of its triangles. Where the
/// rule in effect is not Inside::winding, the surface is the mesh as it was given, and is not
/// repeated here.
ClosedSurface surface_with_inside(const MeshData& mesh, const HalfEdges& sides,
                                  const MeshTraits& traits, Inside rule, Workers& workers);

/// The same as closed_surface() for a mesh that stays open: nothing is left out but doubles, and
/// only holes with small caps are closed.
ClosedSurface mended_surface(const MeshData& mesh, Workers& workers);

}  // namespace pierce
