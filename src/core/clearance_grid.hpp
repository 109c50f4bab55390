#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/core/box.hpp"
#include "pierce/core/constants.hpp"
#include "pierce/core/view.hpp"

namespace pierce {

struct Triangle;

/// A lower bound of the distance from any point to a closed solid, looked up in one cell of a regular grid.
/// What it proves: a point with positive clearance lies in the unbounded outside of the surface, that far from it.
struct ClearanceGridView {
    Box box;                ///< the cells' union; reaches at least one cell beyond the solid on every side
    double cell = 0;        ///< edge length of a cell; zero: no grid, nothing is known
    std::uint32_t size[3] = {0, 0, 0};
    View<const std::uint8_t> steps;  ///< [cell / constants::clearance_steps_per_cell], x fastest

    /// Distance from `p` to the solid is at least this; zero inside, near it, or where no grid was made.
    PIERCE_HD double operator()(Vec3d p) const {
        if (!(cell > 0)) return 0.0;
        const double beyond = box.distance(p);
        if (beyond > 0) return beyond;
        std::uint32_t index[3];
        for (int i = 0; i < 3; ++i) {
            const auto k = static_cast<std::uint32_t>((p[i] - box.lower[i]) / cell);
            index[i] = k < size[i] ? k : size[i] - 1;
        }
        const std::uint8_t s = steps[(static_cast<std::size_t>(index[2]) * size[1] + index[1]) * size[0] + index[0]];
        return s * (cell / constants::clearance_steps_per_cell);
    }
};

/// Owns the cells of a ClearanceGridView.
struct ClearanceGrid {
    ClearanceGridView layout;
    std::vector<std::uint8_t> steps;

    ClearanceGridView view() const {
        ClearanceGridView v = layout;
        v.steps = view_of(steps);
        return v;
    }
};

/// Builds the grid of a closed surface: cells a triangle may touch are marked, the outside is flooded from the border,
/// and every outside cell gets the gap to the nearest cell that is not outside (separable exact distance transform,
/// after Felzenszwalb and Huttenlocher 2012, with cells as cubes so that the bound holds for all their points).
ClearanceGrid build_clearance_grid(std::span<const Vec3f> positions, std::span<const Triangle> triangles);

}  // namespace pierce
