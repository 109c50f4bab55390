#pragma once

#include "core/device/number.hpp"
#include "core/device/view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/near_edge.hpp"
#include "core/step/edges/near_edges.hpp"
#include "pierce/min_max.hpp"

/// edges: near edges from step to step.
namespace pierce::stages {

/// Per newly found near edge: where those of its pair begin, and how many there are.
struct CountNearEdges {
    View<const NearEdge> found;
    Number total;
    View<NearEdgesOfPair> of_pairs;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (i > 0 && found[i - 1].directed == found[i].directed) return;
        std::uint32_t end = i + 1;
        while (end < total && found[end].directed == found[i].directed) ++end;
        of_pairs[found[i].directed].first = i;
        of_pairs[found[i].directed].count = end - i;
    }
};

/// Per directed pair: lists its near edges, those of the last step or those newly found. What was
/// proved of an edge still holds if it is found anew.
struct MergeNearEdges {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const PairMemory> memory;
    View<const std::uint32_t> links;
    View<const NearEdgesOfPair> last_of_pairs;  ///< empty if the last step did not remember
    View<const NearEdge> found, last;
    View<NearEdgesOfPair> of_pairs;

    PIERCE_HD NearEdgesOfPair find(std::uint32_t i) const { return of_pairs[i]; }
    PIERCE_HD static std::uint32_t count(const NearEdgesOfPair& of_pair) { return of_pair.count; }
    PIERCE_HD void write(std::uint32_t i, const NearEdgesOfPair& of_pair, std::uint32_t place,
                         NearEdge* near) const {
        const View<const NearEdge> from = of_pair.is_kept ? last : found;
        NearEdgesOfPair before;
        if (!of_pair.is_kept && memory[i].known && last_of_pairs.size > 0)
            before = last_of_pairs[2 * links[i / 2] + i % 2];
        std::uint32_t old = before.first;
        for (std::uint32_t k = 0; k < of_pair.count; ++k) {
            NearEdge& edge = near[place + k];
            edge = from[of_pair.first + k];
            edge.directed = i;
            // Both lists are in the order of edges.
            while (old < before.first + before.count && last[old].edge < edge.edge) ++old;
            if (old < before.first + before.count && last[old].edge == edge.edge)
                take_over(last[old], before.anchor, edge);
        }
        of_pairs[i].first = place;
    }

private:
    PIERCE_HD void take_over(const NearEdge& old, const Frame& anchor, NearEdge& edge) const {
        const DirectedPair& d = directed[edge.directed];
        const auto way = static_cast<float>(way_from(anchor, bodies, d, edge.edge));
        edge.triangles = old.triangles;
        edge.triangles.way_left -= way;
        const float way_left = old.way_left - way,
                    expiry = max_of(old.expiry, d.odometer + way_left);
        if (!(expiry > max_of(edge.expiry, d.odometer))) return;
        edge.expiry = expiry;
        edge.way_left = way_left;
        edge.crosses = old.crosses;
    }
};

}  // namespace pierce::stages
