#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/device/view.hpp"
#include "core/geometry/triangle_pair.hpp"
#include "core/mesh/clearance_grid.hpp"
#include "core/mesh/leaf.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh_build/box_tree.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"

namespace pierce {

/// [length] How much further than the gap of a ring a triangle may be that decides on it: what is
/// nearest beyond the ring is told a little too near. `reach` [length]: of the ring.
inline double gap_loss(double reach, const MeshView& mesh) {
    return constants::ring_gap_loss * reach + constants::touch_tolerance * mesh.box.extent();
}

/// What is the same in two meshes, and what was measured of the first one. What is known of a
/// triangle or a vertex depends on the surface around it only, so it stays true where that has not
/// changed.
class MeshChange {
public:
    /// Nothing is the same if the box around the mesh has changed, as tolerances depend on it.
    /// Keeps copies of what `before` has. Reads positions, triangles and the box of `now`.
    MeshChange(const MeshView& before, const MeshView& now);

    /// True if most triangles are new.
    bool is_another_mesh() const { return 2 * new_triangles_ > before_.size(); }
    /// Per triangle before, which one it is now, or is_gone.
    std::vector<std::uint32_t> triangles_now() const;
    /// Per triangle of the new mesh, the one with which it had a leaf before, or no_triangle.
    std::vector<std::uint32_t> partners(const MeshView& now, View<const bvh::Leaf> before) const;
    /// True if the vertex has the normal that it had before, bit for bit.
    bool keeps_normal(std::uint32_t vertex) const {
        return keeps_sequence_ && vertex < vertices_before_ && !vertex_changed_[vertex];
    }

    /// The ring of a triangle of the new mesh, if its triangles were there before; else null.
    const TriangleRing* ring(const MeshView& now, std::uint32_t triangle) const;
    /// The triangles of the new mesh whose rings may have changed, or whose gaps.
    std::vector<std::uint32_t> triangles_with_changed_rings(const MeshView& now) const;
    /// Calls see(corners, is_new) for all triangles near a box that came or went.
    template <class See>
    void for_each_changed(const Box& region, const See& see) const {
        if (changed_)
            changed_->for_each_in(region,
                                  [&](std::uint32_t i) { see(corners_[i], i < new_triangles_); });
    }
    /// The star clearance of a vertex of the new mesh, if it is known. `reach` [length]: what is
    /// further away from the vertex than that does not matter.
    std::optional<float> star(const MeshView& now, std::uint32_t vertex, double reach) const;
    /// The clearance grid, if the new triangles lie where the grid knows of no outside.
    std::optional<ClearanceGrid> clearance() const;

private:
    bool is_same_around(const Box& region) const;
    bool has_changed_corner(const MeshView& now, std::uint32_t triangle) const;

    std::vector<std::uint32_t> before_;  ///< per triangle: its id in the mesh before
    std::uint32_t triangles_before_, vertices_before_;
    bool keeps_sequence_ = true;  ///< triangles that are the same are in the same order
    std::vector<bool> vertex_changed_;
    std::vector<Corners> corners_;  ///< of the triangles that came or moved, then of those that
                                    ///< went
    std::size_t new_triangles_ = 0;
    std::optional<BoxTree> changed_;  ///< around the same
    Box all_changed_;
    bool same_box_ = false;
    std::vector<TriangleRing> rings_;
    std::vector<float> stars_;
    ClearanceGrid clearance_;
};

}  // namespace pierce
