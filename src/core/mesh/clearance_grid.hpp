#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/device/four.hpp"
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

    /// A lower bound of the distance from the segment between `a` and `b` to the solid, looked up
    /// at four points of it; zero or less if nothing is known.
    PIERCE_HD double along(Vec3d a, Vec3d b) const {
        constexpr double first = 0.5 / Four::count, part = 1.0 / Four::count;
        const Vec3f from = to_float(a - box.lower), way = to_float(b - a);
        std::int32_t index[3][Four::count];
        for (int r = 0; r < 3; ++r) {
            const Four last = static_cast<float>(size[r]) - 1.0f;
            Four at = from[r];
            for (std::uint32_t k = 0; k < Four::count; ++k)
                at.set(k, from[r] + static_cast<float>(first + k * part) * way[r]);
            at = min_of(max_of(at * Four(static_cast<float>(per_length)), 0), last);
            for (std::uint32_t k = 0; k < Four::count; ++k)
                index[r][k] = static_cast<std::int32_t>(at[k]);
        }
        std::uint8_t least = steps_at(index[0][0], index[1][0], index[2][0]);
        for (std::uint32_t k = 1; k < Four::count; ++k)
            least = min_of(steps_at(index[0][k], index[1][k], index[2][k]), least);
        // Along each axis five roundings lead to a cell, by half an ulp each: of both vectors, of
        // the sum, of the length of a cell and of the quotient.
        double size_of_points = 0;
        for (int r = 0; r < 3; ++r)
            size_of_points += static_cast<double>(std::fabs(from[r]) + std::fabs(way[r]));
        const double rounding = 4 * constants::float_ulp * size_of_points;
        return step * least - 0.5 * part * length(b - a) - rounding;
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

/// Builds the grid of a closed surface: cells a triangle may touch are marked, the outside is
/// flooded from the border, and every outside cell gets the gap to the nearest cell that is not
/// outside (separable exact distance transform, after Felzenszwalb and Huttenlocher 2012, with
/// cells as cubes so that the bound holds for all their points).
ClearanceGrid build_clearance_grid(std::span<const Vec3f> positions,
                                   std::span<const Triangle> triangles);

}  // namespace pierce
