#pragma once

#include <utility>

#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/trace/bvh/lbvh.hpp"
#include "pierce/min_max.hpp"

/// The hierarchical LBVH (Pantaleoni and Luebke, HPG 2010): leaves in the same cell of a coarse
/// grid become an LBVH, and the top of the tree, over the cells, is split by the surface area
/// heuristic.
namespace pierce::bvh {

/// True for places in sorted order where a cell begins.
struct BeginsCell {
    Lbvh lbvh;

    PIERCE_HD bool operator()(std::uint32_t i) const { return lbvh.begins(i); }
};

/// Per place in sorted order: its share of building the cells' trees. A finished cell is noted at
/// its first place.
struct BuildCells {
    Lbvh lbvh;
    View<Subtree> cells;

    PIERCE_HD void operator()(std::uint32_t i) const {
        Subtree cell;
        if (lbvh.climb(i, cell)) cells[cell.first] = cell;
    }
};

/// Per cell: moves it next to its neighbours, and notes where each tree's cells begin.
struct GatherCells {
    Lbvh lbvh;
    View<const Subtree> cells;
    View<const std::uint32_t> begins;  ///< first place of every cell
    View<Subtree> gathered;
    View<std::uint32_t> first_cell;  ///< per tree

    PIERCE_HD void operator()(std::uint32_t c) const {
        gathered[c] = cells[begins[c]];
        const std::uint32_t t = lbvh.forest.tree_of_leaf[lbvh.leaves[begins[c]]];
        if (lbvh.forest.trees[t].first == begins[c]) first_cell[t] = c;
    }
};

/// Per tree: splits its cells from the root down. It splits each range at the border between equal
/// bins where the surface area heuristic is least (Wald 2007).
struct BuildTop {
    Forest forest;
    View<Subtree> cells;               ///< reordered, but only within each tree
    View<const std::uint32_t> begins;  ///< first place of every cell, in the order before
                                       ///< reordering
    View<const std::uint32_t> first_cell;

    PIERCE_HD void operator()(std::uint32_t t) const {
        Tree& tree = forest.trees[t];
        // The smaller half comes next and the larger one waits, so that no more halves wait than
        // the number of times that a size can be halved.
        Range waiting[constants::cell_bits];
        std::uint32_t waits = 0;
        Range now{first_cell[t], t + 1 < forest.trees.size ? first_cell[t + 1] : begins.size, {}};
        while (true) {
            if (now.size() == 1) {
                hang(tree, now.place, cells[now.begin].item, cells[now.begin].box);
                if (waits == 0) return;
                now = waiting[--waits];
                continue;
            }
            const BoxF box = box_of(now);
            const std::uint32_t middle = split(now);
            // As in an LBVH, the node that splits before a place is the node at the place before
            // it.
            const std::uint32_t node = begins[middle] - 1;
            hang(tree, now.place, Item::node(node), box);
            const Range left{now.begin, middle, Place::at(node, 0)},
                right{middle, now.end, Place::at(node, 1)};
            const bool left_first = left.size() < right.size();
            waiting[waits++] = left_first ? right : left;
            now = left_first ? left : right;
        }
    }

private:
    static constexpr std::uint32_t bins = constants::split_bins;

    /// Neighbouring cells, and where their subtree will hang.
    struct Range {
        std::uint32_t begin = 0, end = 0;
        Place place;

        PIERCE_HD std::uint32_t size() const { return end - begin; }
    };

    /// Which bin a cell's centre is in, along an axis.
    struct Binning {
        int axis = 0;
        float begin = 0, scale = 0;

        PIERCE_HD std::uint32_t operator()(const BoxF& box) const {
            const float bin = scale * (box.lower[axis] + box.upper[axis] - begin);
            return static_cast<std::uint32_t>(clamp_to(bin, 0.0f, static_cast<float>(bins - 1)));
        }
    };

    PIERCE_HD void hang(Tree& tree, Place place, Item item, const BoxF& box) const {
        if (place.is_root())
            set_root(forest, tree, item);
        else
            set_child(forest, tree, place, item, box);
    }

    PIERCE_HD BoxF box_of(Range range) const {
        BoxF box = cells[range.begin].box;
        for (std::uint32_t c = range.begin + 1; c < range.end; ++c) box.extend(cells[c].box);
        return box;
    }

    /// Reorders the range's cells for the best split, and returns where that is. If no bins tell
    /// the cells apart, the split is in the middle.
    PIERCE_HD std::uint32_t split(Range range) const {
        BoxF centers = BoxF::none();  // twice the centres
        for (std::uint32_t c = range.begin; c < range.end; ++c) {
            const Vec3f center = cells[c].box.lower + cells[c].box.upper;
            centers.extend({center, center});
        }
        float least = INFINITY;
        Binning best;
        std::uint32_t border = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const float begin = centers.lower[axis], size = centers.upper[axis] - begin;
            if (!(size > 0)) continue;
            const Binning binning{axis, begin, static_cast<float>(bins) / size};
            const std::uint32_t found = best_border(range, binning, least);
            if (found == 0) continue;
            border = found;
            best = binning;
        }
        if (border == 0) return range.begin + range.size() / 2;
        std::uint32_t left = range.begin, right = range.end;
        while (left < right) {
            if (best(cells[left].box) < border) {
                ++left;
                continue;
            }
            const Subtree cell = cells[left];
            cells[left] = cells[--right];
            cells[right] = cell;
        }
        return left;
    }

    /// The first bin right of the best border between bins, or 0 if none costs less than `least`,
    /// which it updates.
    PIERCE_HD std::uint32_t best_border(Range range, const Binning& binning, float& least) const {
        BoxF box[bins];
        std::uint32_t leaves[bins] = {};
        for (BoxF& b : box) b = BoxF::none();
        for (std::uint32_t c = range.begin; c < range.end; ++c) {
            const std::uint32_t b = binning(cells[c].box);
            box[b].extend(cells[c].box);
            leaves[b] += cells[c].leaves();
        }
        float right_cost[bins];  // of bins b and beyond
        BoxF side = BoxF::none();
        std::uint32_t count = 0;
        for (std::uint32_t b = bins - 1; b > 0; --b) {
            side.extend(box[b]);
            count += leaves[b];
            right_cost[b] = count == 0 ? INFINITY : static_cast<float>(count) * side.half_area();
        }
        side = BoxF::none();
        count = 0;
        std::uint32_t border = 0;
        for (std::uint32_t b = 1; b < bins; ++b) {
            side.extend(box[b - 1]);
            count += leaves[b - 1];
            if (count == 0) continue;
            const float cost = static_cast<float>(count) * side.half_area() + right_cost[b];
            if (!(cost < least)) continue;
            least = cost;
            border = b;
        }
        return border;
    }
};

/// Builds all trees of a forest from sorted leaves.
template <Executor E>
class Hlbvh {
public:
    /// `lbvh` is that of whole trees. `forest.visits` must be no_node everywhere.
    void build(E& executor, const Forest& forest, Lbvh lbvh) {
        lbvh.group_bits += constants::cell_bits;
        const std::uint32_t leaves = lbvh.leaves.size;
        cells_.resize(leaves);
        begins_.resize(leaves);
        executor.for_each(leaves, BuildCells{lbvh, view_of(cells_)});
        const std::uint32_t count = executor.number(
            executor.select(ListId::tree_cells, leaves, BeginsCell{lbvh}, view_of(begins_)));
        gathered_.resize(count);
        first_cell_.resize(forest.trees.size);
        const View<const std::uint32_t> begins{begins_.data(), count};
        executor.for_each(count, GatherCells{.lbvh = lbvh,
                                             .cells = view_of(std::as_const(cells_)),
                                             .begins = begins,
                                             .gathered = view_of(gathered_),
                                             .first_cell = view_of(first_cell_)});
        executor.for_each(forest.trees.size,
                          BuildTop{.forest = forest,
                                   .cells = view_of(gathered_),
                                   .begins = begins,
                                   .first_cell = view_of(std::as_const(first_cell_))});
    }

private:
    template <class T>
    using Buffer = typename E::template Buffer<T>;

    Buffer<Subtree> cells_, gathered_;
    Buffer<std::uint32_t> begins_, first_cell_;
};

}  // namespace pierce::bvh
