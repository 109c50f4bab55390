#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/mesh/clearance_grid.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/box_tree.hpp"

namespace pierce {

/// What is the same in two meshes, and what was measured of the first one. What is known of a
/// triangle or a vertex depends on the surface around it only, so it stays true where that has not
/// changed.
class MeshChange {
public:
    /// Nothing is the same if the box around the mesh has changed, as tolerances depend on it.
    /// Keeps copies of what `before` has.
    MeshChange(const MeshView& before, const MeshView& now);

    /// The ring of a triangle of the new mesh, if it is known. `reach` [length]: what is further
    /// away from the triangle than that does not matter.
    std::optional<TriangleRing> ring(const MeshView& now, std::uint32_t triangle,
                                     double reach) const;
    /// The star clearance of a vertex of the new mesh, if it is known; `reach` as above.
    std::optional<float> star(const MeshView& now, std::uint32_t vertex, double reach) const;
    /// The clearance grid, if the new triangles lie where the grid knows of no outside.
    std::optional<ClearanceGrid> clearance() const;

private:
    bool is_same_around(const Box& region) const;

    std::vector<std::uint32_t> before_;  ///< per triangle: its id in the mesh before
    std::vector<bool> vertex_changed_;
    std::optional<BoxTree> changed_;  ///< around the triangles that came, went or moved
    std::vector<Box> came_;
    bool same_box_ = false;
    std::vector<TriangleRing> rings_;
    std::vector<float> stars_;
    ClearanceGrid clearance_;
};

}  // namespace pierce
