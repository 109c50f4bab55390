#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/device/view.hpp"
#include "core/mesh/clearance_grid.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// Two parallel planes around the part of a surface that is near a cell of a clearance grid, and a
/// cone around its normals. Near is what the cell reaches when it grows by
/// constants::slab_reach on every side. Coordinates are relative to the cell's middle.
struct CellSlab {
    std::int8_t normal[3] = {0, 0, 0};  ///< [1 / slab_normal_unit] not longer than 1
    std::uint8_t sine = 255;  ///< [1 / 255] of the cone's half angle; 255: normals face any way
    std::int16_t low = 0, high = 0;  ///< [cell / slab_units] along the normal
};
static_assert(sizeof(CellSlab) == 8);

/// What is certain about a segment and a surface.
struct SegmentProof {
    double gap = 0;   ///< [length] the surface is at least this far away
    double once = 0;  ///< [length] the segment crosses the surface once at most, in whatever way
                      ///< both its ends move by less than this; not less than `gap`

    /// True if it pays to know that the segment does not cross more than once, although less is
    /// known of whether it crosses.
    PIERCE_HD bool prefers_once() const { return once > constants::edge_once_pays * gap; }
};

/// The slabs of a closed surface, looked up in the cells of its clearance grid.
struct SlabGridView {
    ClearanceGridView clearance;
    View<const std::uint32_t> first;   ///< per layer of cells along z, where its slabs begin
    View<const std::uint16_t> place;   ///< per cell, which of its layer's slabs; or no_slab
    View<const CellSlab> slabs;        ///< empty: nothing is known

    static constexpr std::uint16_t no_slab = 0xffff;

    /// Looks at the segment in places that are so close to each other that every part of it is near
    /// the cell of one of them. Of a segment that is too long for that nothing is known.
    PIERCE_HD SegmentProof along(Vec3d a, Vec3d b) const {
        SegmentProof proof;
        if (slabs.size == 0) return proof;
        // Outside of the grid the surface is at least a cell away, and so is it from a place within
        // rounding of it.
        const Vec3d way = b - a;
        double begin = 0, end = 1;
        for (int r = 0; r < 3; ++r) {
            const double low = clearance.box.lower[r] - a[r], high = clearance.box.upper[r] - a[r];
            if (way[r] > 0) {
                begin = max_of(low / way[r], begin);
                end = min_of(high / way[r], end);
            } else if (way[r] < 0) {
                begin = max_of(high / way[r], begin);
                end = min_of(low / way[r], end);
            } else if (!(low < 0 && high > 0)) {
                end = -1;
            }
        }
        const double cell = clearance.cell,
                     whole = (constants::slab_reach - constants::slab_rounding) * cell;
        if (!(begin < end)) return {whole, whole};
        const double size = length(way), cells = (end - begin) * size * clearance.per_length;
        std::uint32_t parts = 4;
        while (constants::slab_part * parts < cells && parts < constants::slab_parts_most)
            parts *= 2;
        const double half = 0.5 * cells / parts;  // [cell] of a part
        const double room = constants::slab_reach - half - constants::slab_rounding;
        if (!(room > 0)) return proof;
        const double shrink = 1 / size;
        const Vec3f along{static_cast<float>(way.x * shrink), static_cast<float>(way.y * shrink),
                          static_cast<float>(way.z * shrink)};
        const Vec3f from = to_float(clearance.per_length *
                                    (a + begin * way - clearance.box.lower)),
                    step = to_float((clearance.per_length * (end - begin) / parts) * way);
        const auto reach = static_cast<float>(half), most = static_cast<float>(room),
                   turn = static_cast<float>(constants::slab_turn * size * clearance.per_length);
        float gap = INFINITY;
        if (begin > 0 || end < 1) gap = static_cast<float>(whole * clearance.per_length);
        float once[2] = {gap, gap};
        for (std::uint32_t k = 0; k < parts; ++k) {
            const float at = static_cast<float>(k) + 0.5f;
            float part_gap = most, part_once[2] = {most, most};
            look({from.x + at * step.x, from.y + at * step.y, from.z + at * step.z}, along, reach,
                 turn, most, part_gap, part_once);
            gap = min_of(part_gap, gap);
            for (int s = 0; s < 2; ++s)
                once[s] = min_of(max_of(part_gap, part_once[s]), once[s]);
            if (!(max_of(once[0], once[1]) > 0)) break;
        }
        proof.gap = static_cast<double>(gap) * cell;
        proof.once = static_cast<double>(max_of(once[0], once[1])) * cell;
        return proof;
    }

private:
    /// One part of a segment [cell].
    PIERCE_HD void look(Vec3f p, Vec3f along, float reach, float turn, float most, float& gap,
                        float (&once)[2]) const {
        std::int32_t index[3];
        for (int r = 0; r < 3; ++r)
            index[r] = static_cast<std::int32_t>(
                clamp_to(p[r], 0.0f, static_cast<float>(clearance.size[r]) - 1.0f));
        const std::size_t cell = clearance.index_of(index[0], index[1], index[2]);
        const float clear = (1.0f / constants::clearance_steps_per_cell) *
                                static_cast<float>(clearance.steps[cell]) -
                            reach - static_cast<float>(constants::slab_rounding);
        const std::uint16_t at = place[cell];
        if (at == no_slab) {
            gap = max_of(clear, most);
            return;
        }
        const CellSlab& slab = slabs[first[static_cast<std::uint32_t>(index[2])] + at];
        constexpr auto unit = static_cast<float>(1 / constants::slab_normal_unit);
        const Vec3f n{unit * slab.normal[0], unit * slab.normal[1], unit * slab.normal[2]};
        const Vec3f q{p.x - static_cast<float>(index[0]) - 0.5f,
                      p.y - static_cast<float>(index[1]) - 0.5f,
                      p.z - static_cast<float>(index[2]) - 0.5f};
        constexpr auto length_unit = static_cast<float>(1 / constants::slab_units);
        const float height = n.x * q.x + n.y * q.y + n.z * q.z,
                    slope = n.x * along.x + n.y * along.y + n.z * along.z;
        const float apart = max_of(height - length_unit * slab.high,
                                   length_unit * slab.low - height) -
                            reach * std::fabs(slope) - static_cast<float>(constants::slab_rounding);
        gap = max_of(min_of(apart, most), clear);
        const float sure = turn * (std::fabs(slope) - static_cast<float>(constants::slab_rounding) -
                                   (1.0f / 255) * slab.sine);
        once[0] = slope > 0 && slab.sine < 255 ? min_of(sure, most) : -1.0f;
        once[1] = slope < 0 && slab.sine < 255 ? min_of(sure, most) : -1.0f;
    }
};

}  // namespace pierce
