#pragma once

#include <utility>

#include "core/device/atomics.hpp"
#include "core/device/view.hpp"
#include "core/execute/executor.hpp"
#include "core/trace/bvh/lbvh.hpp"
#include "core/trace/bvh/treelet.hpp"

/// Treelet restructuring (Karras and Aila, HPG 2013): the top of every subtree, cut off where it
/// has seven parts, is put together anew in the best of all ways.
namespace pierce::bvh {

/// Per place in `leaves`: climbs from that leaf, counting leaves in `forest.visits`, as long as it
/// is the second to reach each node, up to a node with enough leaves.
struct FindTreelets {
    Forest forest;
    View<const std::uint32_t> leaves;
    std::uint32_t smallest = 0;  ///< leaves that are enough
    View<std::uint32_t> found;   ///< the node, or no_node

    PIERCE_HD void operator()(std::uint32_t i) const {
        found[i] = no_node;
        std::uint32_t count = 1;
        for (Place place = forest.leaf_places[leaves[i]]; !place.is_root();
             place = forest.nodes[place.node()].parent) {
            const std::uint32_t others = atomic_add(forest.visits[place.node()], count);
            if (others == 0) return;
            count += others;
            if (count < smallest) continue;
            found[i] = place.node();
            return;
        }
    }
};

/// Per node whose subtree is finished: improves the treelet there, and hands on the node above if
/// it is the last child of that node to get there. Lanes go on with that node themselves.
template <class Who>
struct ImproveTreelets {
    Forest forest;
    View<const std::uint32_t> nodes, places;  ///< thing i is nodes[places[i]]
    bool climbs = false;  ///< goes on with the node above; otherwise leaves it to the next launch
    View<std::uint32_t> next;  ///< the node above, or no_node

    static constexpr bool has_rooms = true;

    PIERCE_HD void operator()(std::uint32_t item) const {
        typename Treelet<Who>::Areas areas;
        const ShareOfSets<Who> sets;
        const std::uint32_t i = Who::thing_of(item);
        std::uint32_t node = nodes[places[i]];
        if (Who::is_first()) next[i] = no_node;
        while (true) {
            Treelet<Who>(forest, node, areas).improve(forest, sets);
            Who::settle();
            const Place place = forest.nodes[node].parent;
            if (place.is_root()) return;
            node = place.node();
            std::uint32_t before = 0;
            if (Who::is_first()) before = atomic_add(forest.visits[node], 1);
            if (Who::from(0, before) == 0) return;
            if (climbs) continue;
            next[i] = node;
            return;
        }
    }
};

/// True for places that hold a node.
struct HoldsNode {
    View<const std::uint32_t> nodes;

    PIERCE_HD bool operator()(std::uint32_t i) const { return nodes[i] != no_node; }
};

/// Restructures all trees of a forest, from the leaves up. A launch improves every treelet whose
/// subtree is finished, a thread each, so that neighbouring threads all have work. When few
/// treelets are left, a last launch climbs to the roots, with lanes that share each treelet.
template <Executor E>
class TreeletRestructuring {
public:
    /// `leaves`: all leaves, neighbours close together. The values it leaves in `forest.visits` are
    /// of no use.
    void run(E& executor, const Forest& forest, View<const std::uint32_t> leaves) {
        for (Buffer* buffer : {&nodes_, &next_, &places_}) buffer->resize(leaves.size);
        for (std::uint32_t round = 0; round < constants::treelet_rounds; ++round) {
            executor.for_each(leaves.size, Fill{forest.visits, 0});
            executor.for_each(leaves.size,
                              FindTreelets{.forest = forest,
                                           .leaves = leaves,
                                           .smallest = constants::treelet_parts << round,
                                           .found = view_of(next_)});
            std::uint32_t n = keep(executor, leaves.size);
            for (; n > constants::treelet_crowd; n = keep(executor, n))
                executor.for_each(n, improvement<Alone>(forest, false));
            executor.for_each(executor.in_lanes(n), improvement<Lanes>(forest, true));
        }
    }

private:
    using Buffer = typename E::template Buffer<std::uint32_t>;

    template <class Who>
    ImproveTreelets<Who> improvement(const Forest& forest, bool climbs) {
        return {.forest = forest,
                .nodes = view_of(std::as_const(nodes_)),
                .places = view_of(std::as_const(places_)),
                .climbs = climbs,
                .next = view_of(next_)};
    }

    /// Makes the nodes among the first n of next_ the next ones; returns how many there are.
    std::uint32_t keep(E& executor, std::uint32_t n) {
        std::swap(nodes_, next_);
        return executor.number(executor.select(
            ListId::treelets, n, HoldsNode{view_of(std::as_const(nodes_))}, view_of(places_)));
    }

    Buffer nodes_, next_, places_;
};

}  // namespace pierce::bvh
