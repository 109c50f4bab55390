#pragma once

#include <cmath>
#include <cstdint>

#include "core/device/lanes.hpp"
#include "core/device/ordered_float.hpp"
#include "core/device/view.hpp"
#include "core/trace/bvh/forest.hpp"
#include "core/trace/bvh/lbvh.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

/// The top of a hierarchical LBVH: the cells of a tree are halved, and the halves again, where the
/// surface area heuristic is least (Wald 2007), by several lanes at a time (after Garanzha et al.,
/// HPG 2011).
namespace pierce::bvh {

/// Neighbouring cells of a tree, and where the subtree over them will hang.
struct CellRange {
    std::uint32_t begin = 0, end = 0;
    std::uint32_t tree = 0;
    Place place;

    PIERCE_HD std::uint32_t size() const { return end - begin; }
};

/// Where the lanes that split a range meet: bins along each axis. Sides of boxes are ordered
/// integers; bins side by side lie side by side, so that lanes seldom wait for each other.
struct SplitRoom {
    static constexpr std::uint32_t bins = constants::split_bins;
    static constexpr std::uint64_t none = ~std::uint64_t{0};

    std::uint32_t lower[3][3][bins], upper[3][3][bins];  ///< coordinate, axis, bin
    std::uint32_t leaves[3][bins];
    float cost[3][2][bins];   ///< per border between bins: of the cells before it, and beyond
    unsigned long long best;  ///< the least cost of a split, in its upper half, and which split

    PIERCE_HD void clear(std::uint32_t bin) {
        for (int axis = 0; axis < 3; ++axis) {
            leaves[axis][bin] = 0;
            for (int k = 0; k < 3; ++k) {
                lower[k][axis][bin] = ordered_bits(INFINITY);
                upper[k][axis][bin] = ordered_bits(-INFINITY);
            }
        }
    }

    /// Adds a cell to a bin. NaN extends nothing.
    PIERCE_HD void add(int axis, std::uint32_t bin, const Subtree& cell) {
        keep_sum(leaves[axis][bin], cell.leaves());
        for (int k = 0; k < 3; ++k) {
            const float low = cell.box.lower[k], high = cell.box.upper[k];
            if (low == low) keep_least(lower[k][axis][bin], ordered_bits(low));
            if (high == high) keep_largest(upper[k][axis][bin], ordered_bits(high));
        }
    }

    PIERCE_HD BoxF box(std::uint32_t axis, std::uint32_t bin) const {
        BoxF all;
        for (int k = 0; k < 3; ++k) {
            all.lower[k] = from_ordered_bits(lower[k][axis][bin]);
            all.upper[k] = from_ordered_bits(upper[k][axis][bin]);
        }
        return all;
    }
};

/// Per range of cells, one for a few lanes: halves it. A large range's halves are left to the next
/// launch, and a small range is split down to its cells.
struct SplitCells {
    Forest forest;
    View<const Subtree> cells;
    View<const std::uint32_t> begins;  ///< first place of every cell
    View<std::uint32_t> order;         ///< the cells, those of each range side by side
    View<std::uint32_t> scratch;       ///< one per cell
    View<const CellRange> ranges;
    View<const std::uint32_t> places;  ///< item i is ranges[places[i]]
    View<CellRange> next;              ///< two per item: halves to be split; or empty ones

    static constexpr bool has_rooms = true;

    PIERCE_HD void operator()(std::uint32_t item) const {
        Room<SplitRoom> shared;
        SplitRoom& room = *shared;
        const std::uint32_t i = Lanes::thing_of(item);
        // The smaller half comes next and the larger one waits, so that no more halves wait than
        // the number of times that a size can be halved.
        CellRange waiting[constants::split_alone_bits + 1];
        std::uint32_t waits = 0;
        CellRange now = ranges[places[i]];
        const bool alone = now.size() <= constants::split_alone;
        if (Lanes::is_first()) next[2 * i] = next[2 * i + 1] = {};
        while (true) {
            if (now.size() == 1) {
                const Subtree& cell = cells[order[now.begin]];
                if (Lanes::is_first()) hang(now, cell.item, cell.box);
                if (waits == 0) return;
                now = waiting[--waits];
                continue;
            }
            BoxF box;
            const std::uint32_t middle = split(now, room, box);
            // As in an LBVH, the node that splits before a place is the node at the place before
            // it.
            const std::uint32_t node = begins[middle] - 1;
            if (Lanes::is_first()) hang(now, Item::node(node), box);
            CellRange left = now, right = now;
            left.end = right.begin = middle;
            left.place = Place::at(node, 0);
            right.place = Place::at(node, 1);
            if (!alone) {
                if (!Lanes::is_first()) return;
                next[2 * i] = left;
                next[2 * i + 1] = right;
                return;
            }
            const bool left_first = left.size() < right.size();
            waiting[waits++] = left_first ? right : left;
            now = left_first ? left : right;
        }
    }

private:
    static constexpr std::uint32_t bins = SplitRoom::bins;

    PIERCE_HD void hang(const CellRange& range, Item item, const BoxF& box) const {
        Tree& tree = forest.trees[range.tree];
        if (range.place.is_root())
            set_root(forest, tree, item);
        else
            set_child(forest, tree, range.place, item, box);
    }

    PIERCE_HD const Subtree& cell_at(std::uint32_t place) const { return cells[order[place]]; }

    PIERCE_HD static float center_of(const BoxF& box, int axis) {
        return box.lower[axis] + box.upper[axis];
    }

    /// Reorders the range's cells for the best split, and returns where that is. If no split is
    /// better than another, it is in the middle. Measures the range's box.
    PIERCE_HD std::uint32_t split(const CellRange& range, SplitRoom& room, BoxF& box) const {
        if (range.size() == 2) {
            box = join(cell_at(range.begin).box, cell_at(range.begin + 1).box);
            return range.begin + 1;
        }
        BoxF centers;
        measure(range, box, centers);
        Lanes::settle();
        if (Lanes::is_first()) room.best = SplitRoom::none;
        const bool few = range.size() <= constants::few_cells;
        if (few)
            try_every_cell(range, room);
        else
            try_borders_of_bins(range, centers, room);
        if (room.best == SplitRoom::none) return range.begin + range.size() / 2;
        const auto best = static_cast<std::uint32_t>(room.best);
        const int axis = static_cast<int>(best / range_splits);
        const std::uint32_t which = best % range_splits;
        if (few) {
            const AtOrBefore before{axis, range.begin + which,
                                    center_of(cell_at(range.begin + which).box, axis)};
            return reorder(range, before);
        }
        return reorder(range, BeforeBorder{Binning(centers, axis), which});
    }

    /// Splits along an axis that the room's `best` can tell apart.
    static constexpr std::uint32_t range_splits = bins;
    static_assert(constants::few_cells <= range_splits);

    /// The box around the range's cells, and around their centres, twice as large.
    PIERCE_HD void measure(const CellRange& range, BoxF& box, BoxF& centers) const {
        box = centers = BoxF::none();
        Lanes::share(range.begin, range.end, [&](std::uint32_t k) {
            const BoxF cell = cell_at(k).box;
            const Vec3f center = cell.lower + cell.upper;
            box.extend(cell);
            centers.extend({center, center});
        });
        for (BoxF* all : {&box, &centers})
            for (int axis = 0; axis < 3; ++axis) {
                all->lower[axis] = Lanes::least(all->lower[axis]);
                all->upper[axis] = Lanes::largest(all->upper[axis]);
            }
    }

    /// The cells up to one of them, along an axis; those with equal centres are in order.
    struct AtOrBefore {
        int axis;
        std::uint32_t place;
        float center;

        PIERCE_HD bool operator()(std::uint32_t k, const BoxF& box) const {
            const float c = center_of(box, axis);
            return c < center || (c == center && k <= place);
        }
    };

    /// Notes the best of all splits into the cells up to one and those beyond, along every axis.
    PIERCE_HD void try_every_cell(const CellRange& range, SplitRoom& room) const {
        Lanes::settle();
        Lanes::share(0, 3 * range.size(), [&](std::uint32_t k) {
            const auto axis = static_cast<int>(k / range.size());
            const std::uint32_t which = k % range.size(), place = range.begin + which;
            const AtOrBefore before{axis, place, center_of(cell_at(place).box, axis)};
            BoxF box[2] = {BoxF::none(), BoxF::none()};
            std::uint32_t leaves[2] = {};
            for (std::uint32_t other = range.begin; other < range.end; ++other) {
                const Subtree& cell = cell_at(other);
                if (before(other, cell.box)) {
                    box[0].extend(cell.box);
                    leaves[0] += cell.leaves();
                } else {
                    box[1].extend(cell.box);
                    leaves[1] += cell.leaves();
                }
            }
            if (leaves[0] > 0 && leaves[1] > 0)
                note(room, axis, which, cost_of(box[0], leaves[0]) + cost_of(box[1], leaves[1]));
        });
        Lanes::settle();
    }

    /// Which bin a cell's centre is in, along an axis.
    struct Binning {
        int axis;
        float begin, scale;

        PIERCE_HD Binning(const BoxF& centers, int along)
            : axis(along),
              begin(centers.lower[along]),
              scale(static_cast<float>(bins) / (centers.upper[along] - centers.lower[along])) {}
        PIERCE_HD std::uint32_t operator()(const BoxF& box) const {
            const float bin = scale * (center_of(box, axis) - begin);
            return static_cast<std::uint32_t>(clamp_to(bin, 0.0f, static_cast<float>(bins - 1)));
        }
    };

    struct BeforeBorder {
        Binning bin;
        std::uint32_t border;

        PIERCE_HD bool operator()(std::uint32_t, const BoxF& box) const {
            return bin(box) < border;
        }
    };

    /// Notes the best border between equal bins, along every axis.
    PIERCE_HD void try_borders_of_bins(const CellRange& range, const BoxF& centers,
                                       SplitRoom& room) const {
        Lanes::share(0, bins, [&](std::uint32_t b) { room.clear(b); });
        Lanes::settle();
        const Binning bin_of[3] = {{centers, 0}, {centers, 1}, {centers, 2}};
        Lanes::share(range.begin, range.end, [&](std::uint32_t k) {
            const Subtree& cell = cell_at(k);
            for (int axis = 0; axis < 3; ++axis) room.add(axis, bin_of[axis](cell.box), cell);
        });
        Lanes::settle();
        Lanes::share(0, 6, [&](std::uint32_t k) { add_up_costs(room, k / 2, k % 2); });
        Lanes::settle();
        Lanes::share(0, 3 * (bins - 1), [&](std::uint32_t k) {
            const std::uint32_t axis = k / (bins - 1), border = k % (bins - 1) + 1;
            note(room, static_cast<int>(axis), border,
                 room.cost[axis][0][border] + room.cost[axis][1][border]);
        });
        Lanes::settle();
    }

    /// Along an axis, per border: the cost of the bins before it, or of those beyond.
    PIERCE_HD static void add_up_costs(SplitRoom& room, std::uint32_t axis, std::uint32_t side) {
        BoxF box = BoxF::none();
        std::uint32_t leaves = 0;
        for (std::uint32_t k = 1; k < bins; ++k) {
            const std::uint32_t border = side == 0 ? k : bins - k,
                                b = side == 0 ? border - 1 : border;
            box.extend(room.box(axis, b));
            leaves += room.leaves[axis][b];
            room.cost[axis][side][border] = leaves == 0 ? INFINITY : cost_of(box, leaves);
        }
    }

    PIERCE_HD static float cost_of(const BoxF& box, std::uint32_t leaves) {
        return static_cast<float>(leaves) * box.half_area();
    }

    PIERCE_HD static void note(SplitRoom& room, int axis, std::uint32_t which, float cost) {
        if (!(cost < INFINITY)) return;
        const std::uint32_t code = static_cast<std::uint32_t>(axis) * range_splits + which;
        keep_least(room.best, static_cast<unsigned long long>(ordered_bits(cost)) << 32 | code);
    }

    /// Moves the cells before a split to the front, in the order that they have; returns where the
    /// others begin.
    template <class Before>
    PIERCE_HD std::uint32_t reorder(const CellRange& range, const Before& is_before) const {
        std::uint32_t middle = range.begin, beyond = 0;
        for (std::uint32_t begin = range.begin; begin < range.end; begin += Lanes::count) {
            const std::uint32_t k = begin + Lanes::lane();
            const bool exists = k < range.end;
            const std::uint32_t cell = exists ? order[k] : 0;
            const bool before = exists && is_before(k, cells[cell].box);
            const std::uint32_t to_front = Lanes::ask(before),
                                to_back = Lanes::ask(exists && !before);
            if (before)
                order[middle + Lanes::before(to_front)] = cell;
            else if (exists)
                scratch[range.begin + beyond + Lanes::before(to_back)] = cell;
            middle += bit_count(to_front);
            beyond += bit_count(to_back);
        }
        Lanes::settle();
        Lanes::share(0, beyond,
                     [&](std::uint32_t k) { order[middle + k] = scratch[range.begin + k]; });
        Lanes::settle();
        return middle;
    }
};

/// True for places that hold a range.
struct HoldsRange {
    View<const CellRange> ranges;

    PIERCE_HD bool operator()(std::uint32_t i) const { return ranges[i].size() > 0; }
};

}  // namespace pierce::bvh
