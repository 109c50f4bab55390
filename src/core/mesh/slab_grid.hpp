#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/device/four.hpp"
#include "core/device/view.hpp"
#include "core/mesh/clearance_grid.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// Two parallel planes around the part of a surface that is near a cell of a regular grid, and a
/// cone around its normals. Near is what the cell reaches when it grows by constants::slab_reach on
/// every side. Heights are relative to the cell's middle, along the normal.
struct CellSlab {
    std::int8_t normal[3] = {0, 0, 0};  ///< [1 / slab_normal_unit] not longer than 1
    std::int8_t sine = slab_any_way;    ///< [1 / slab_normal_unit] of the cone's half angle
    std::int16_t low = INT16_MAX, high = INT16_MIN;  ///< [cell / slab_units]

    /// A sine of normals that may face any way.
    static constexpr std::int8_t slab_any_way = 127;
};
static_assert(sizeof(CellSlab) == 8);

/// A cell of such a grid: its clearance, and where its slab is.
struct SlabCell {
    std::uint32_t steps : 8;  ///< as in ClearanceGridView
    std::uint32_t slab : 24;  ///< 0 is the slab of a cell without a surface near
};
static_assert(sizeof(SlabCell) == 4);

/// What is certain about a segment and a surface.
struct SegmentProof {
    double gap = 0;   ///< [length] the surface is at least this far away
    double once = 0;  ///< [length] the segment crosses the surface once at most, in whatever way
                      ///< both its ends move by less than this; not less than `gap`

    /// True if it pays to know that the segment does not cross more than once, although less is
    /// known of whether it crosses.
    PIERCE_HD bool prefers_once() const { return once > constants::edge_once_pays * gap; }
};

/// The slabs of a closed surface, looked up in the cells of a clearance grid that is coarser than
/// the one for vertices.
struct SlabGridView : ClearanceGridLayout {
    View<const SlabCell> cells;  ///< x fastest; empty: nothing is known
    View<const CellSlab> slabs;

    /// Looks at the segment in places that are so close to each other that every part of it is near
    /// the cell of one of them. Of a segment that is too long for that nothing is known.
    PIERCE_HD SegmentProof along(Vec3d a, Vec3d b) const {
        if (cells.size == 0) return {};
        Vec3d from = per_length * (a - box.lower), to = per_length * (b - box.lower);
        // Outside of the grid the surface is at least a cell away.
        float gap = INFINITY;
        if (!is_within(from) || !is_within(to)) {
            if (!is_close(from) || !is_close(to)) return {};
            gap = static_cast<float>(constants::slab_reach - constants::slab_rounding);
            if (!clip(from, to))
                return {cell * static_cast<double>(gap), cell * static_cast<double>(gap)};
        }
        const Vec3f begin = to_float(from), way = to_float(to - from);
        const float reach = length(way);
        std::uint32_t fours = 1;
        while (constants::slab_part * Four::count * fours < static_cast<double>(reach) &&
               fours < constants::slab_fours_most)
            fours *= 2;
        const Parts parts(begin, way, reach, 1.0f / static_cast<float>(fours * Four::count), *this);
        if (!(parts.most > 0)) return {};
        float once[2] = {gap, gap};
        for (std::uint32_t k = 0; k < fours; ++k) {
            parts.look(static_cast<float>(k * Four::count), gap, once);
            if (!(max_of(once[0], once[1]) > 0)) return {};
        }
        return {cell * static_cast<double>(gap),
                cell * static_cast<double>(max_of(once[0], once[1]))};
    }

private:
    /// A segment in equal parts, in cells.
    struct Parts {
        Vec3f begin, step;
        float half;  ///< of a part
        float turn;
        float most;  ///< how far away a surface still is if no slab tells otherwise
        const SlabGridView& grid;

        PIERCE_HD Parts(Vec3f from, Vec3f way, float reach, float part, const SlabGridView& cells)
            : begin(from),
              step(part * way),
              half(0.5f * part * reach),
              turn(static_cast<float>(constants::slab_turn) / part),
              most(static_cast<float>(constants::slab_reach - constants::slab_rounding) - half),
              grid(cells) {}

        /// Four parts from `first` on.
        PIERCE_HD void look(float first, float& gap, float (&once)[2]) const {
            constexpr auto rounding = static_cast<float>(constants::slab_rounding),
                           unit = static_cast<float>(1 / constants::slab_normal_unit),
                           height_unit = static_cast<float>(1 / constants::slab_units);
            Four at = first + 0.5f;
            for (std::uint32_t k = 1; k < Four::count; ++k)
                at.set(k, first + 0.5f + static_cast<float>(k));
            const FourVec3 p{Four(begin.x) + at * Four(step.x), Four(begin.y) + at * Four(step.y),
                             Four(begin.z) + at * Four(step.z)};
            const FourVec3 cell{cell_of(p.x, 0), cell_of(p.y, 1), cell_of(p.z, 2)};
            const Four index = (cell.z * Four(static_cast<float>(grid.size[1])) + cell.y) *
                                   Four(static_cast<float>(grid.size[0])) +
                               cell.x;
            SlabCell found[Four::count];
            std::uint32_t least = 0xff;
            for (std::uint32_t k = 0; k < Four::count; ++k) {
                found[k] = grid.cells[static_cast<std::uint32_t>(index[k])];
                least = min_of(std::uint32_t{found[k].steps}, least);
            }
            constexpr float step_length = 1.0f / constants::clearance_steps_per_cell;
            const float clear = step_length * static_cast<float>(least) - (half + rounding);
            if (clear > 0) {
                gap = min_of(clear, gap);
                once[0] = min_of(clear, once[0]);
                once[1] = min_of(clear, once[1]);
                return;
            }
            FourWords normals{}, heights{};
            Four steps = 0;
            for (std::uint32_t k = 0; k < Four::count; ++k) {
                steps.set(k, static_cast<float>(found[k].steps));
                std::uint32_t words[2];
                std::memcpy(words, &grid.slabs[found[k].slab], sizeof words);
                normals.word[k] = words[0];
                heights.word[k] = words[1];
            }
            const Four x = normals.field<0, 8>(), y = normals.field<8, 8>(),
                       z = normals.field<16, 8>();
            const FourVec3 n = FourVec3{x, y, z} * Four(unit);
            const Four sine = Four(unit) * normals.field<24, 8>(),
                       low = Four(height_unit) * heights.field<0, 16>(),
                       high = Four(height_unit) * heights.field<16, 16>();
            const Four middle = 0.5f;
            const FourVec3 q{p.x - cell.x - middle, p.y - cell.y - middle, p.z - cell.z - middle};
            const Four height = dot(n, q), slope = dot(n, FourVec3{step.x, step.y, step.z}),
                       steep = abs_of(slope);
            const Four apart = max_of(height - high, low - height) - Four(0.5f) * steep -
                               Four(rounding);
            const Four part_gap = max_of(min_of(apart, most),
                                         Four(step_length) * steps - Four(half + rounding));
            const Four sure = min_of(
                Four(turn) * (steep - (sine + Four(rounding)) * Four(2 * half)), most);
            const Four up = max_of(part_gap, where(0, slope, sure, -1)),
                       down = max_of(part_gap, where(slope, 0, sure, -1));
            gap = min_of(least_of(part_gap), gap);
            once[0] = min_of(least_of(up), once[0]);
            once[1] = min_of(least_of(down), once[1]);
        }

        PIERCE_HD Four cell_of(Four p, int axis) const {
            return whole_part_of(min_of(max_of(p, 0), static_cast<float>(grid.size[axis]) - 1.0f));
        }
    };

    PIERCE_HD bool is_within(Vec3d p) const {
        return p.x > 0 && p.x < size[0] && p.y > 0 && p.y < size[1] && p.z > 0 && p.z < size[2];
    }

    /// True if clipping a segment that ends here rounds less than float32 does [cell].
    PIERCE_HD static bool is_close(Vec3d p) {
        return std::fabs(p.x) < constants::slab_far && std::fabs(p.y) < constants::slab_far &&
               std::fabs(p.z) < constants::slab_far;
    }

    /// Leaves the part of a segment that is in the grid [cell]; false if there is none.
    PIERCE_HD bool clip(Vec3d& a, Vec3d& b) const {
        const Vec3d way = b - a;
        double begin = 0, end = 1;
        for (int r = 0; r < 3; ++r) {
            if (!(way[r] < 0 || way[r] > 0)) {
                if (!(a[r] > 0 && a[r] < size[r])) return false;
                continue;
            }
            const double low = -a[r] / way[r], high = (size[r] - a[r]) / way[r];
            begin = max_of(min_of(low, high), begin);
            end = min_of(max_of(low, high), end);
        }
        if (!(begin < end)) return false;
        b = a + end * way;
        a += begin * way;
        return true;
    }
};

}  // namespace pierce
