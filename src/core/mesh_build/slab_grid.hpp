#pragma once

#include <span>
#include <vector>

#include "core/mesh/slab_grid.hpp"

namespace pierce {

/// Owns the arrays of a SlabGridView.
struct SlabGrid {
    std::vector<SlabCell> cells;
    std::vector<CellSlab> slabs;
};

/// Finds the slabs of a closed surface for the cells of a clearance grid: around each cell the
/// triangles are clipped, their mean normal is the slab's, and the slab is as thick as what is left
/// of them.
SlabGrid build_slab_grid(const ClearanceGrid& clearance, std::span<const Vec3f> positions,
                         std::span<const Triangle> triangles);

}  // namespace pierce
