#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/workers.hpp"
#include "core/mesh/slab_grid.hpp"

namespace pierce {

/// How many cells a grid of slabs has along the longest side of a mesh. Coarse meshes have few: on
/// them slabs spare little, and take most of the time in which the mesh is added.
std::uint32_t slab_resolution(std::size_t triangles);

/// Owns the arrays of a SlabGridView.
struct SlabGrid {
    std::vector<SlabCell> cells;
    std::vector<CellSlab> slabs;
};

/// Finds the slabs of a closed surface for the cells of a clearance grid: around each cell the
/// triangles are clipped, their mean normal is the slab's, and the slab is as thick as what is left
/// of them.
SlabGrid build_slab_grid(const ClearanceGrid& clearance, std::span<const Vec3f> positions,
                         std::span<const Triangle> triangles, Workers& workers);

}  // namespace pierce
