#pragma once

#include <utility>

#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/trace/bvh/cell_split.hpp"
#include "core/trace/bvh/lbvh.hpp"

/// The hierarchical LBVH (Pantaleoni and Luebke, HPG 2010): leaves in the same cell of a coarse
/// grid become an LBVH, and the top of the tree, over the cells, is split by the surface area
/// heuristic as cell_split.hpp says.
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
    View<std::uint32_t> order;       ///< the cells side by side

    PIERCE_HD void operator()(std::uint32_t c) const {
        order[c] = c;
        gathered[c] = cells[begins[c]];
        const std::uint32_t t = lbvh.forest.tree_of_leaf[lbvh.leaves[begins[c]]];
        if (lbvh.forest.trees[t].first == begins[c]) first_cell[t] = c;
    }
};

/// Per tree: all its cells, to be split.
struct WholeTrees {
    View<const std::uint32_t> first_cell;
    std::uint32_t count = 0;  ///< cells
    View<CellRange> ranges;
    View<std::uint32_t> places;

    PIERCE_HD void operator()(std::uint32_t t) const {
        const std::uint32_t end = t + 1 < first_cell.size ? first_cell[t + 1] : count;
        ranges[t] = {.begin = first_cell[t], .end = end, .tree = t, .place = {}};
        places[t] = t;
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
        for (auto* buffer : {&begins_, &order_, &scratch_}) buffer->resize(leaves);
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
                                             .first_cell = view_of(first_cell_),
                                             .order = view_of(order_)});
        split(executor, forest, begins);
    }

private:
    template <class T>
    using Buffer = typename E::template Buffer<T>;

    /// Builds the trees over their cells. A launch halves every range of cells, until the ranges
    /// are so small that a launch splits each down to its cells.
    void split(E& executor, const Forest& forest, View<const std::uint32_t> begins) {
        ranges_.resize(forest.trees.size);
        places_.resize(forest.trees.size);
        executor.for_each(forest.trees.size,
                          WholeTrees{.first_cell = view_of(std::as_const(first_cell_)),
                                     .count = begins.size,
                                     .ranges = view_of(ranges_),
                                     .places = view_of(places_)});
        for (std::uint32_t n = forest.trees.size; n > 0;) {
            next_.resize(2 * n);
            executor.for_each(executor.in_lanes(n),
                              SplitCells{.forest = forest,
                                         .cells = view_of(std::as_const(gathered_)),
                                         .begins = begins,
                                         .order = view_of(order_),
                                         .scratch = view_of(scratch_),
                                         .ranges = view_of(std::as_const(ranges_)),
                                         .places = view_of(std::as_const(places_)),
                                         .next = view_of(next_)});
            std::swap(ranges_, next_);
            places_.resize(2 * n);
            n = executor.number(executor.select(ListId::tree_ranges, 2 * n,
                                                HoldsRange{view_of(std::as_const(ranges_))},
                                                view_of(places_)));
        }
    }

    Buffer<Subtree> cells_, gathered_;
    Buffer<CellRange> ranges_, next_;
    Buffer<std::uint32_t> begins_, first_cell_, order_, scratch_, places_;
};

}  // namespace pierce::bvh
