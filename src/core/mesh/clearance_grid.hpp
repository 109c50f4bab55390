#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/device/view.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

struct Triangle;

/// Where the cells of a regular grid are, and the unit of their values.
struct ClearanceGridLayout {
    Box box;  ///< the cells' union; reaches at least one cell beyond the solid on every side
    double cell = 0;        ///< edge length of a cell
    double per_length = 0;  ///< cells per unit of length
    double step = 0;        ///< [length] of one step of clearance
    std::int32_t size[3] = {0, 0, 0};

    PIERCE_HD std::size_t index_of(std::int32_t x, std::int32_t y, std::int32_t z) const {
        const std::int32_t index = (z * size[1] + y) * size[0] + x;
        return static_cast<std::size_t>(index);
    }
};

/// A lower bound of the distance from any point to a closed solid, looked up in one cell of a
/// regular grid. A point with positive clearance is proved to lie in the unbounded outside of the
/// surface, at least that far from it.
struct ClearanceGridView : ClearanceGridLayout {
    View<const std::uint8_t> steps;  ///< per cell, x fastest; empty: nothing is known

    /// A lower bound of the distance from `p` to the solid; zero inside the solid, near it, or
    /// where no grid was made. For a point outside the box the nearest cell counts: the solid lies
    /// in the box, so moving `p` into the box brings it closer.
    PIERCE_HD double operator()(Vec3d p) const {
        if (steps.size == 0) return 0.0;
        std::int32_t at[3];
        for (int i = 0; i < 3; ++i)
            at[i] = static_cast<std::int32_t>(
                clamp_to((p[i] - box.lower[i]) * per_length, 0.0, size[i] - 1.0));
        return step * steps_at(at[0], at[1], at[2]);
    }

    PIERCE_HD std::uint8_t steps_at(std::int32_t x, std::int32_t y, std::int32_t z) const {
        return steps[index_of(x, y, z)];
    }
};

/// Owns the cells of a ClearanceGridView.
struct ClearanceGrid {
    ClearanceGridLayout layout;
    std::vector<std::uint8_t> steps;
};

/// Where the cells of that grid are; no cells if the surface has no extent.
ClearanceGridLayout clearance_layout(std::span<const Vec3f> positions,
                                     std::span<const Triangle> triangles,
                                     std::uint32_t resolution = constants::grid_resolution);

/// Builds the grid of a closed surface, with `resolution` cells along its longest side: cells a
/// triangle may touch are marked, the outside is flooded from the border, and every outside cell
/// gets the gap to the nearest cell that is not outside (separable exact distance transform, after
/// Felzenszwalb and Huttenlocher 2012, with cells as cubes so that the bound holds for all their
/// points).
ClearanceGrid build_clearance_grid(std::span<const Vec3f> positions,
                                   std::span<const Triangle> triangles,
                                   std::uint32_t resolution = constants::grid_resolution);

}  // namespace pierce
