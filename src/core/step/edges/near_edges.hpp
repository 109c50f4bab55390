#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/edge_group.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/edges/edge_cull.hpp"
#include "core/step/edges/near_edge.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "pierce/min_max.hpp"

/// edges, second part: which edges are near the target's surface. Spheres around a group's edges
/// are compared with the target's clearance; of edges that are left, several places are. Of a
/// target that deforms, or whose clearance is too coarse, boxes of edges are compared with its tree
/// of boxes. No edge that crosses the surface is left out.
namespace pierce::stages {

/// The box around a segment, larger by `slack`.
PIERCE_HD inline QuickBox box_around(Vec3d from, Vec3d to, double slack) {
    QuickBox box;
    for (int r = 0; r < 3; ++r) {
        box.lower[r] = not_above(static_cast<float>(min_of(from[r], to[r]) - slack));
        box.upper[r] = not_below(static_cast<float>(max_of(from[r], to[r]) + slack));
    }
    return box;
}

/// An edge in the space of its target.
struct PlacedEdge {
    Vec3d a, b;

    PIERCE_HD PlacedEdge(const BodyView& source, const DirectedPair& d, const Edge& edge)
        : a(d.to_space.to_parent(to_double(source.positions[edge.vertex[0]]))),
          b(d.to_space.to_parent(to_double(source.positions[edge.vertex[1]]))) {}
};

/// Boxes along the part of an edge that is near the box around its target, each with what is
/// `reach` away from its part of the edge, by `slack` at most: two, or more if that part is much
/// longer than the target's edges.
PIERCE_HD inline FewBoxes boxes_along(const PlacedEdge& edge, const BodyView& target, double slack,
                                      const Box& reach) {
    const BoxLevels levels(target.mesh.triangles.size);
    const QuickBox& around = target.box_nodes[levels.begin[levels.count - 1]].around;
    const Vec3d way = edge.b - edge.a;
    double begin = 0, end = 1;
    for (int r = 0; r < 3; ++r) {
        if (!(std::fabs(way[r]) > slack)) continue;
        const double low = (static_cast<double>(around.lower[r]) - slack - edge.a[r]) / way[r],
                     high = (static_cast<double>(around.upper[r]) + slack - edge.a[r]) / way[r];
        begin = max_of(min_of(low, high), begin);
        end = min_of(max_of(low, high), end);
    }
    // Rounding of a quotient moves a place along the edge by less than its share of this.
    begin = max_of(begin - constants::double_rounding, 0.0);
    end = max_of(min_of(end + constants::double_rounding, 1.0), begin);
    const double edges = (end - begin) * length(way) / target.mesh.mean_edge_length;
    FewBoxes boxes;
    for (boxes.count = 2; boxes.count < FewBoxes::most && edges > boxes.count;) boxes.count += 2;
    const double part = (end - begin) / boxes.count;
    for (std::uint32_t k = 0; k < boxes.count; ++k) {
        Box box;
        box.extend(edge.a + (begin + k * part) * way);
        box.extend(edge.a + (begin + (k + 1) * part) * way);
        boxes.box[k] = box_around(box.lower + reach.lower, box.upper + reach.upper, 0.0);
    }
    return boxes;
}

/// The same with all that is not further away than `slack`.
PIERCE_HD inline FewBoxes boxes_along(const PlacedEdge& edge, const BodyView& target,
                                      double slack) {
    const Vec3d all{slack, slack, slack};
    return boxes_along(edge, target, slack, {-all, all});
}

/// [length] How far an edge's ends are from where an earlier frame of the pair has them, in the
/// target's space; infinite if one of the bodies deforms.
PIERCE_HD inline double way_from(const Frame& anchor, View<const BodyView> bodies,
                                 const DirectedPair& d, std::uint32_t edge) {
    const BodyView& source = bodies[d.source];
    if (source.motion == Motion::deforming || bodies[d.target].motion == Motion::deforming)
        return INFINITY;
    double squared = 0;
    for (std::uint32_t v : source.mesh.edges[edge].vertex) {
        const Vec3d p = to_double(source.positions[v]);
        squared = max_of(length_squared(d.to_space.to_parent(p) - anchor.to_parent(p)), squared);
    }
    return std::sqrt(squared);
}

/// True if the target's clearance says which edges of the source are near: the target does not
/// deform, and edges are longer than the grid's cells.
PIERCE_HD inline bool clearance_tells(const BodyView& source, const BodyView& target) {
    return target.motion != Motion::deforming &&
           target.mesh.clearance_at.cell < source.mesh.mean_edge_length;
}

/// What is certain of an edge and the surface of its target without looking at triangles, by the
/// target's box and by the slabs of its cells. Of a target that deforms nothing is known.
PIERCE_HD inline SegmentProof proof_of(const BodyView& source, const BodyView& target,
                                       const PlacedEdge& edge) {
    if (target.motion == Motion::deforming) return {};
    const Box& box = target.mesh.box;
    double beyond = 0;
    for (int r = 0; r < 3; ++r)
        beyond = max_of(max_of(box.lower[r] - max_of(edge.a[r], edge.b[r]),
                               min_of(edge.a[r], edge.b[r]) - box.upper[r]),
                        beyond);
    const double coarse = min_of(static_cast<double>(target.mesh.slabs_at.cell),
                                 source.mesh.mean_edge_length);
    if (beyond > constants::edge_beyond_enough * coarse) return {beyond, beyond};
    const SegmentProof proof = target.mesh.slabs_by_cell().along(edge.a, edge.b);
    return {max_of(proof.gap, beyond), max_of(proof.once, beyond)};
}

/// Per group of edges, or per edge: lists the edges that may be near the target's surface.
template <class Share>
struct FindNearEdges {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> groups;
    View<std::uint32_t> gaps;  ///< per directed pair, of the edges left out; empty if steps do not
                               ///< remember
    bool asks_boxes = true;    ///< false: KeepNearBoxes asks them

    static constexpr bool in_order = true;

    /// A bit for each, and until when it is proved that it does not cross the surface, or not more
    /// than once.
    struct Found {
        std::uint32_t mask = 0;
        std::uint32_t may_cross = 0;  ///< a bit for each that may cross until then
        float way_left[Share::count];
    };

    PIERCE_HD Found find(std::uint32_t i) const {
        const CullItem item = group_of(i);
        const DirectedPair& d = directed[item.directed];
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        const EdgeGroup& group = source.mesh.edge_groups[item.index];
        const PatchBlock& block = source.mesh.edge_blocks[item.index / constants::block_size];
        const EdgePlace place(bodies, directed, item.directed, gaps.size > 0);
        const BallsNearby<Share> balls(
            target, place.to_fit, patch_center(source.mesh.edge_blocks, item.index), group.middles,
            group.half, static_cast<double>(block.radius[item.index % constants::block_size]),
            place.slack);
        const double slack = edge_slack(directed, item.directed),
                     more = gaps.size > 0 ? edge_skin(bodies, d) : 0.0;
        Found found;
        const std::uint32_t all = first_bits(edge_group_length(source.mesh, item.index));
        found.mask = Share::mine(balls.near & all);
        float least = gaps.size > 0 ? balls.least_gap(all & ~balls.near) : 0.0f;
        for (std::uint32_t left = found.mask; left != 0; left &= left - 1) {
            const std::uint32_t k = lowest_bit(left);
            const SegmentProof proof = proof_of(source, target, placed(item, k));
            const auto gap = static_cast<float>(proof.gap - slack - more);
            if (gap > 0) {
                found.mask ^= 1u << k;
                least = min_of(gap, least);
            }
            const bool may_cross = proof.prefers_once();
            found.may_cross |= static_cast<std::uint32_t>(may_cross) << k;
            found.way_left[k - Share::first()] = static_cast<float>(
                (may_cross ? proof.once : proof.gap) - slack);
        }
        if (asks_boxes && found.mask != 0 && !clearance_tells(source, target)) {
            const std::uint32_t before = found.mask;
            found.mask = by_boxes(i, found.mask, slack + more);
            if (found.mask != before) least = 0;
        }
        if (gaps.size > 0) note_gap(gaps[item.directed], least);
        return found;
    }
    PIERCE_HD static std::uint32_t count(const Found& found) { return bit_count(found.mask); }
    PIERCE_HD void write(std::uint32_t i, const Found& found, std::uint32_t place,
                         NearEdge* near) const {
        const CullItem item = group_of(i);
        const float odometer = directed[item.directed].odometer;
        for (std::uint32_t left = found.mask; left != 0; left &= left - 1) {
            const std::uint32_t k = lowest_bit(left);
            near[place++] = {.directed = item.directed,
                             .edge = item.index * constants::group_size + k,
                             .expiry = odometer + found.way_left[k - Share::first()],
                             .way_left = found.way_left[k - Share::first()],
                             .crosses = found.may_cross >> k & 1u ? some_triangle : no_triangle,
                             .triangles = {}};
        }
    }

private:
    PIERCE_HD const CullItem& group_of(std::uint32_t i) const { return groups[Share::group_of(i)]; }

    PIERCE_HD PlacedEdge placed(const CullItem& item, std::uint32_t k) const {
        const DirectedPair& d = directed[item.directed];
        const BodyView& source = bodies[d.source];
        return {source, d, source.mesh.edges[item.index * constants::group_size + k]};
    }

    /// Of some edges of a group, those whose box, larger by `slack`, meets a box around sixteen
    /// triangles of the target.
    PIERCE_HD std::uint32_t by_boxes(std::uint32_t i, std::uint32_t mask, double slack) const {
        const CullItem item = group_of(i);
        const BodyView& target = bodies[directed[item.directed].target];
        QuickBox box[Offsets::count], around;
        for (std::uint32_t left = mask; left != 0; left &= left - 1) {
            const std::uint32_t k = lowest_bit(left);
            const PlacedEdge edge = placed(item, k);
            box[k] = box_around(edge.a, edge.b, slack);
            around.extend(box[k]);
        }
        std::uint32_t near = 0;
        for_each_group(target.box_nodes, BoxLevels(target.mesh.triangles.size), around,
                       [&](std::uint32_t group, std::uint32_t) {
                           for (std::uint32_t left = mask & ~near; left != 0; left &= left - 1) {
                               const std::uint32_t k = lowest_bit(left);
                               if (target.box_nodes[group].boxes.near(box[k]) != 0) near |= 1u << k;
                           }
                           return near == mask;
                       });
        return near;
    }
};

/// Per edge that is near by its sphere: lists those whose box meets a box around a triangle of the
/// target, if clearance does not say enough.
struct KeepNearBoxes {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const NearEdge> edges;
    View<std::uint32_t> gaps;  ///< as those of FindNearEdges

    static constexpr bool in_order = true;

    PIERCE_HD bool find(std::uint32_t i) const {
        const NearEdge& edge = edges[i];
        const DirectedPair& d = directed[edge.directed];
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        if (clearance_tells(source, target)) return true;
        const double slack = edge_slack(directed, edge.directed) +
                             (gaps.size > 0 ? edge_skin(bodies, d) : 0.0);
        const PlacedEdge placed(source, d, source.mesh.edges[edge.edge]);
        const bool near = for_each_group(target.box_nodes, BoxLevels(target.mesh.triangles.size),
                                         box_around(placed.a, placed.b, slack),
                                         [](std::uint32_t, std::uint32_t) { return true; });
        if (!near && gaps.size > 0) note_gap(gaps[edge.directed], 0);
        return near;
    }
    PIERCE_HD static std::uint32_t count(bool near) { return near; }
    PIERCE_HD void write(std::uint32_t i, bool near, std::uint32_t place, NearEdge* kept) const {
        if (near) kept[place] = edges[i];
    }
};

}  // namespace pierce::stages
