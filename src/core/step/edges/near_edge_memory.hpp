#pragma once

#include "core/device/view.hpp"
#include "core/step/common/records.hpp"

/// edges: near edges from step to step.
namespace pierce::stages {

/// Per newly found near edge: where those of its pair begin, and how many there are.
struct CountNearEdges {
    View<const NearEdge> found;
    View<NearEdgesOfPair> of_pairs;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (i > 0 && found[i - 1].directed == found[i].directed) return;
        std::uint32_t end = i + 1;
        while (end < found.size && found[end].directed == found[i].directed) ++end;
        of_pairs[found[i].directed].first = i;
        of_pairs[found[i].directed].count = end - i;
    }
};

/// Per directed pair: lists its near edges, those of the last step or those newly found.
struct MergeNearEdges {
    View<const NearEdge> found, last;
    View<NearEdgesOfPair> of_pairs;

    PIERCE_HD NearEdgesOfPair find(std::uint32_t i) const { return of_pairs[i]; }
    PIERCE_HD static std::uint32_t count(const NearEdgesOfPair& of_pair) { return of_pair.count; }
    PIERCE_HD void write(std::uint32_t i, const NearEdgesOfPair& of_pair, std::uint32_t place,
                         NearEdge* near) const {
        const View<const NearEdge> from = of_pair.is_kept ? last : found;
        for (std::uint32_t k = 0; k < of_pair.count; ++k) {
            near[place + k] = from[of_pair.first + k];
            near[place + k].directed = i;
        }
        of_pairs[i].first = place;
    }
};

}  // namespace pierce::stages
