#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/edge_cull.hpp"
#include "core/step/edges/near_edge.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/solids/directed_pair.hpp"

/// edges, third part: which near edges are asked for chords.
namespace pierce::stages {

/// True for edges that may cross more than one triangle: no proof to the contrary holds. Of the
/// other edges, marks the pairs of those that may cross one. Pairs in which nothing has moved are
/// not asked, nor are those whose edges are only kept for later.
struct MayCross {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const NearEdgesOfPair> of_pairs;  ///< empty if steps do not remember
    View<NearEdge> near;
    PairsAsked asked;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        NearEdge& edge = near[i];
        const DirectedPair& d = directed[edge.directed];
        if (d.still || !asked(edge.directed / 2)) return false;
        if (!(edge.expiry > d.odometer)) {
            if (!(edge.way_left > 0) || of_pairs.size == 0) return true;
            const double left = static_cast<double>(edge.way_left) -
                                way_from(of_pairs[edge.directed].anchor, bodies, d, edge.edge);
            if (!(left > 0)) return true;
            edge.expiry = d.odometer + static_cast<float>(left);
        }
        if (edge.crosses != no_triangle)
            asked.marks.set(edge.directed / 2, PairMarks::edge_crosses);
        return false;
    }
};

/// True for pairs that have no contact with a depth so far although an edge may cross a triangle,
/// and the end of an edge may be inside. If each vertex inside is in contact, only ends are left
/// that touch the surface, and those of pairs without a contact: their rays may begin within the
/// touch tolerance of it.
struct IsCrossed {
    PairMarks marks;
    bool inside_is_contact = false;

    PIERCE_HD bool operator()(std::uint32_t pair) const {
        return marks.any(pair, PairMarks::edge_crosses) && !marks.any(pair, PairMarks::has_depth) &&
               (!inside_is_contact || marks.any(pair, PairMarks::vertex_touches) ||
                !marks.any(pair, PairMarks::in_contact));
    }
};

/// True for edges of such pairs, if they may cross a triangle.
struct MayCrossOne {
    View<const NearEdge> near;
    IsCrossed is_crossed;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        return near[i].crosses != no_triangle && is_crossed(near[i].directed / 2);
    }
};

}  // namespace pierce::stages
