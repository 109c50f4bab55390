#include "pierce/mesh_fix.hpp"

#include <utility>

#include "core/base/workers.hpp"
#include "core/mesh/half_edges.hpp"
#include "core/mesh_build/closed_surface.hpp"
#include "core/mesh_build/mesh_topology.hpp"
#include "pierce/ids.hpp"

namespace pierce {

FixedMesh fix_mesh(const MeshData& mesh) {
    check_mesh_data("to fix", mesh);
    const HalfEdges sides(mesh.triangles, mesh.positions.size());
    Workers workers(0);
    ClosedSurface surface = surface_with_inside(mesh, sides, traits_of(mesh, sides, {}),
                                                Inside::automatic, workers);
    if (!surface.inside.exists()) surface = mended_surface(mesh);
    if (surface.triangles.empty()) surface.triangles = mesh.triangles;
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
    if (!fixed.done.exists()) {
        // What was mended may have an inside now.
        const HalfEdges now(fixed.mesh.triangles, fixed.mesh.positions.size());
        fixed.done.rule = surface_with_inside(fixed.mesh, now, traits_of(fixed.mesh, now, {}),
                                              Inside::automatic, workers)
                              .inside.rule;
    }
    return fixed;
}

}  // namespace pierce
