#include "pierce/mesh_fix.hpp"

#include <utility>

#include "core/base/workers.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh_build/closed_surface.hpp"
#include "core/mesh_build/mesh_topology.hpp"
#include "pierce/ids.hpp"

namespace pierce {
namespace {

ClosedSurface surface_of(const MeshData& mesh, Workers& workers) {
    const HalfEdges sides(mesh.triangles, mesh.positions.size());
    return surface_with_inside(mesh, sides, traits_of(mesh, sides, {}), Inside::automatic, workers);
}

/// The mesh with a surface's triangles, and without the vertices that it does not need.
FixedMesh with_surface(const MeshData& mesh, ClosedSurface surface) {
    if (surface.triangles.empty()) {  // the mesh stays as it is
        surface.triangles = mesh.triangles;
        surface.inside = {.rule = surface.inside.rule,
                          .covered_triangles = surface.inside.covered_triangles};
    }
    FixedMesh fixed{{{}, std::move(surface.triangles)}, {}, surface.inside};
    std::vector<std::uint32_t> place(mesh.positions.size(), no_vertex);
    for (Triangle& t : fixed.mesh.triangles)
        for (std::uint32_t v : t.vertex) place[v] = 0;
    for (std::uint32_t v = 0; v < place.size(); ++v) {
        if (place[v] == no_vertex) continue;
        place[v] = static_cast<std::uint32_t>(fixed.vertices.size());
        fixed.vertices.push_back(v);
        fixed.mesh.positions.push_back(mesh.positions[v]);
    }
    for (Triangle& t : fixed.mesh.triangles)
        for (std::uint32_t& v : t.vertex) v = place[v];
    return fixed;
}

/// What was done first and then.
MeshInside both(const MeshInside& first, const MeshInside& then) {
    return {.rule = then.rule,
            .covered_triangles = then.covered_triangles,
            .joined_vertices = first.joined_vertices + then.joined_vertices,
            .turned_triangles = first.turned_triangles + then.turned_triangles,
            .left_out_triangles = first.left_out_triangles + then.left_out_triangles,
            .holes = first.holes + then.holes,
            .cap_triangles = first.cap_triangles + then.cap_triangles,
            .cap_share = first.cap_share + then.cap_share};
}

}  // namespace

FixedMesh fix_mesh(const MeshData& mesh) {
    check_mesh_data("to fix", mesh);
    Workers workers(0);
    ClosedSurface surface = surface_of(mesh, workers);
    if (surface.inside.exists()) return with_surface(mesh, std::move(surface));
    const FixedMesh mended = with_surface(mesh, mended_surface(mesh, workers));
    // What was mended may have an inside now, and its last holes are closed then.
    FixedMesh fixed = with_surface(mended.mesh, surface_of(mended.mesh, workers));
    for (std::uint32_t& v : fixed.vertices) v = mended.vertices[v];
    fixed.done = both(mended.done, fixed.done);
    return fixed;
}

}  // namespace pierce
