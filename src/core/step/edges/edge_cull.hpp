#pragma once

#include "core/body/body_view.hpp"
#include "core/device/atomics.hpp"
#include "core/device/ordered_float.hpp"
#include "core/device/view.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/edge_group.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/near_edge.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "pierce/min_max.hpp"

/// edges, first part: which edges may reach the other body of their pair, by groups. If the
/// surfaces of two closed bodies cross, an edge of one of them crosses the other: vertices alone
/// may miss that.
namespace pierce::stages {

/// [length] How far from a target's surface edges matter: where they are moved against each other,
/// crossings may be that far away, and a few touch tolerances are for rounding.
PIERCE_HD inline double edge_slack(View<const DirectedPair> directed, std::uint32_t direction) {
    return (constants::nudge + constants::edge_tolerance) * touch_of_pair(directed, direction);
}

/// [length] How far the bodies of a pair may move until it is asked again which edges are near, if
/// steps remember.
PIERCE_HD inline double edge_skin(View<const BodyView> bodies, const DirectedPair& d) {
    const double edge = min_of(bodies[d.source].mesh.mean_edge_length,
                               bodies[d.target].mesh.mean_edge_length),
                 most = constants::edge_skin_most * edge, step = static_cast<double>(d.step);
    if (!(constants::edge_skin_wait * step < most)) return 0;
    return min_of(max_of(constants::edge_skin_steps * step, constants::edge_skin_least * edge),
                  most);
}

/// The least of some gaps [length], noted by any number of items. It starts at 0, which stands for
/// no gap.
PIERCE_HD inline void note_gap(std::uint32_t& least, float gap) {
    atomic_max(least, ~ordered_bits(max_of(gap, 0.0f)));
}
PIERCE_HD inline float noted_gap(std::uint32_t least) {
    return least == 0 ? 0.0f : from_ordered_bits(~least);
}

/// Which pairs' edges are looked at: all pairs', or those of the pairs without any of some marks.
struct PairsAsked {
    PairMarks marks;
    std::uint32_t unless = 0;

    PIERCE_HD bool operator()(std::uint32_t pair) const { return !marks.any(pair, unless); }
};

/// Per directed pair: whether the near edges of the last step are still those that may meet the
/// target. How long those of this step will be, ExpireNearEdges knows. Of pairs that are not asked
/// they are kept for a few steps: contacts without much depth come and go.
struct RecallNearEdges {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    PairsAsked asked;
    View<const PairMemory> memory;
    View<const std::uint32_t> links;
    View<const NearEdgesOfPair> last;  ///< empty if the last step did not remember
    View<NearEdgesOfPair> now;
    View<std::uint32_t> gaps;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[i];
        NearEdgesOfPair of_pair;
        gaps[i] = 0;
        if (memory[i].known && last.size > 0) of_pair = last[2 * links[i / 2] + i % 2];
        of_pair.unasked = asked(i / 2) ? 0 : of_pair.unasked + 1;
        of_pair.is_kept = (of_pair.expiry > d.odometer || d.still) &&
                          of_pair.unasked <= constants::edge_unasked_steps;
        if (!of_pair.is_kept) of_pair = {.anchor = d.to_space};
        now[i] = of_pair;
    }
};

/// Per directed pair whose near edges were found anew: until when all other edges are away from the
/// target.
struct ExpireNearEdges {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    PairsAsked asked;
    View<const std::uint32_t> gaps;
    View<NearEdgesOfPair> of_pairs;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[i];
        if (of_pairs[i].is_kept || !asked(i / 2)) return;
        of_pairs[i].expiry = d.odometer + static_cast<float>(edge_skin(bodies, d)) +
                             noted_gap(gaps[i]);
    }
};

/// True if edges of a directed pair's source are looked at: not those of a body against itself.
PIERCE_HD inline bool asks_edges(View<const BodyView> bodies, const DirectedPair& d) {
    return !d.is_self() && is_asked(bodies[d.source], bodies[d.target], false, 0);
}

/// Per directed pair: lists the blocks of its source's edges, if it is not known which of them are
/// near.
struct ListEdgeBlocks {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const NearEdgesOfPair> of_pairs;  ///< empty if steps do not remember
    PairsAsked asked;

    static constexpr bool in_order = true;

    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        if (!asked(i / 2)) return 0;
        const bool is_kept = of_pairs.size > 0 && of_pairs[i].is_kept;
        return is_kept || !asks_edges(bodies, directed[i])
                   ? 0
                   : edge_block_count(bodies[directed[i].source].mesh);
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t found) { return found; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t found, std::uint32_t place,
                         CullItem* blocks) const {
        write_blocks(i, found, place, blocks);
    }
};

/// Edges of a rest shape as their target sees them: from the rest shape's place to the target's fit
/// frame, and how much further away from the target they count.
struct EdgePlace {
    Frame to_fit;
    double slack = 0;

    PIERCE_HD EdgePlace(View<const BodyView> bodies, View<const DirectedPair> directed,
                        std::uint32_t direction, bool remembers) {
        const DirectedPair& d = directed[direction];
        const BodyView& source = bodies[d.source];
        to_fit = source.motion == Motion::deforming
                     ? relative_frame(source.fit, bodies[d.target].fit)
                     : d.to_fit;
        slack = edge_slack(directed, direction) + source.deviation +
                (remembers ? edge_skin(bodies, d) : 0.0);
    }
};

/// Per block of edges: lists the groups of edges that may reach the target's surface.
struct CullEdgeBlock {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> blocks;
    View<std::uint32_t> gaps;  ///< per directed pair, of the groups left out; empty if steps do not
                               ///< remember

    static constexpr bool in_order = true;

    /// A bit for each.
    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const CullItem item = blocks[i];
        const DirectedPair& d = directed[item.directed];
        const MeshView& mesh = bodies[d.source].mesh;
        const PatchBlock& block = mesh.edge_blocks[item.index];
        const EdgePlace place(bodies, directed, item.directed, gaps.size > 0);
        const BallsNearby<> balls(bodies[d.target], place.to_fit, block.center, block.offsets,
                                  block.radius, static_cast<double>(block.reach), place.slack);
        const std::uint32_t all = first_bits(edge_block_length(mesh, item.index));
        if (gaps.size > 0) note_gap(gaps[item.directed], balls.least_gap(all & ~balls.near));
        return balls.near & all;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t mask, std::uint32_t place,
                         CullItem* groups) const {
        write_parts(blocks[i], constants::block_size, mask, place, groups);
    }
};

/// Per group of edges that may reach its target's surface: marks the target.
struct MarkTargetsOfGroups {
    View<const DirectedPair> directed;
    View<const CullItem> groups;
    View<std::uint32_t> wanted;  ///< per body

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        atomic_mark(wanted[directed[groups[i].directed].target]);
    }
};

/// Per directed pair that is asked: marks the target, if near edges are kept from the last step.
struct MarkTargetsOfKept {
    View<const DirectedPair> directed;
    View<const NearEdgesOfPair> of_pairs;
    View<std::uint32_t> wanted;  ///< per body

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        if (of_pairs[i].count > 0 && of_pairs[i].unasked == 0)
            atomic_mark(wanted[directed[i].target]);
    }
};

}  // namespace pierce::stages
