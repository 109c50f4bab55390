#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/geometry/closest_points_of_segments.hpp"
#include "core/geometry/triangle.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/edge_group.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/margin/covered_ridge.hpp"
#include "core/step/margin/edge_wedge.hpp"
#include "core/step/margin/margin_stages.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/ray.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"

/// margin, second part: edges of one body that are nearer to edges of the other than the margin.
namespace pierce::stages {

/// [length] The margin of a pair's edges: of the first body's edges to those of the second. Both
/// need an inside, which tells ridges from valleys.
PIERCE_HD inline double edge_margin_of(View<const BodyView> bodies, View<const DirectedPair> d,
                                       std::uint32_t direction) {
    return direction % 2 == 0 && bodies[d[direction].source].is_solid()
               ? margin_of(bodies, d[direction])
               : 0.0;
}

/// [length] How far two ridges of a pair may have passed each other and still be in contact: a
/// few times as far as the pair is deep, if that is no deeper than a share of the margin. Pairs
/// that only touch have no depth, so constants::skin touch tolerances are added. Measured: with the
/// whole margin for deep pairs, a step of 8,192 pairs of deforming tori takes three times as long
/// on an H200.
PIERCE_HD inline double passed_margin_of(const PairMarks& marks, std::uint32_t direction,
                                         double margin, double touch) {
    const std::uint32_t pair = direction / 2;
    const double most = constants::passed_share * margin, deepest = marks.depth_of(pair);
    const bool is_shallow = marks.depth.size > 0 && marks.any(pair, PairMarks::in_contact) &&
                            deepest <= most;
    return is_shallow ? min_of(most, constants::passed_depths * deepest + constants::skin * touch)
                      : 0.0;
}

/// Per directed pair whose edges have a margin: lists its source's blocks of edges.
struct ListMarginEdgeBlocks {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;

    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        return edge_margin_of(bodies, directed, i) > 0
                   ? edge_block_count(bodies[directed[i].source].mesh)
                   : 0;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t found) { return found; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t found, std::uint32_t place,
                         CullItem* blocks) const {
        write_blocks(i, found, place, blocks);
    }
};

/// Where a pair's edges are, for spheres around edges of the rest shape.
PIERCE_HD inline EdgePlace margin_place(View<const BodyView> bodies,
                                        View<const DirectedPair> directed,
                                        std::uint32_t direction) {
    EdgePlace place(bodies, directed, direction, false);
    place.slack += edge_margin_of(bodies, directed, direction);
    return place;
}

/// Per block of edges: lists the groups of edges that may be nearer than the margin.
struct CullMarginEdgeBlock {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> blocks;

    /// A bit for each.
    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const CullItem item = blocks[i];
        const DirectedPair& d = directed[item.directed];
        const MeshView& mesh = bodies[d.source].mesh;
        const PatchBlock& block = mesh.edge_blocks[item.index];
        const EdgePlace place = margin_place(bodies, directed, item.directed);
        const BallsNearby<> balls(bodies[d.target], place.to_fit, block.center, block.offsets,
                                  block.radius, static_cast<double>(block.reach), place.slack);
        return balls.near & first_bits(edge_block_length(mesh, item.index));
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t mask, std::uint32_t place,
                         CullItem* groups) const {
        write_parts(blocks[i], constants::block_size, mask, place, groups);
    }
};

/// Per group: lists the edges that may be nearer than the margin.
struct CullMarginEdges {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> groups;

    /// A bit for each.
    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        const CullItem item = groups[i];
        const DirectedPair& d = directed[item.directed];
        const MeshView& mesh = bodies[d.source].mesh;
        const EdgeGroup& group = mesh.edge_groups[item.index];
        const PatchBlock& block = mesh.edge_blocks[item.index / constants::block_size];
        const EdgePlace place = margin_place(bodies, directed, item.directed);
        const BallsNearby<> balls(
            bodies[d.target], place.to_fit, patch_center(mesh.edge_blocks, item.index),
            group.middles, group.half,
            static_cast<double>(block.radius[item.index % constants::block_size]), place.slack);
        return balls.near & first_bits(edge_group_length(mesh, item.index));
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t mask, std::uint32_t place,
                         CullItem* edges) const {
        write_parts(groups[i], constants::group_size, mask, place, edges);
    }
};

/// A ridge near the target, and the faces that meet in it.
struct NearRidge {
    std::uint32_t directed = 0, edge = 0;
    EdgeFaces faces;
};

/// Per edge: lists those that are ridges and not further from the target than the margin, as far as
/// the target's clearance knows.
struct KeepNearRidges {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> edges;

    /// The faces exist if the edge is listed.
    PIERCE_HD EdgeFaces find(std::uint32_t i) const {
        const CullItem& item = edges[i];
        const DirectedPair& d = directed[item.directed];
        const BodyView &source = bodies[d.source], &target = bodies[d.target];
        const Edge& edge = source.mesh.edges[item.index];
        const EdgeFaces faces(source, edge);
        const bool is_near = is_ridge(source, edge, faces, d.touch) &&
                             cover_of(source, faces) != Cover::wholly &&
                             (target.mesh.slabs.size == 0 ||
                              !(proof_of(source, target, {source, d, edge}).gap >
                                edge_margin_of(bodies, directed, item.directed) + d.touch));
        return is_near ? faces : EdgeFaces();
    }
    PIERCE_HD static std::uint32_t count(const EdgeFaces& faces) { return faces.exist(); }
    PIERCE_HD void write(std::uint32_t i, const EdgeFaces& faces, std::uint32_t place,
                         NearRidge* ridges) const {
        if (faces.exist()) ridges[place] = {edges[i].directed, edges[i].index, faces};
    }
};

/// A ridge, and triangles of a group of the target that may be near it.
struct RidgeNearGroup {
    std::uint32_t ridge = 0;  ///< its place among the near ridges
    std::uint32_t group = 0;
    std::uint32_t mask = 0;
};

/// Per ridge: lists the groups of triangles that it may be near, where it may be in contact.
struct FindGroupsNearRidge {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const NearRidge> ridges;
    PairMarks marks;

    /// The first groups. Measured: with four of them, so many soft tori of a lattice look twice
    /// that steps take 2 % longer on an H200.
    struct Found {
        static constexpr std::uint32_t most = 8;

        std::uint32_t count = 0;
        std::uint32_t group[most];
        std::uint32_t mask[most];
    };

    PIERCE_HD Found find(std::uint32_t i) const {
        Found found;
        each(ridges[i], [&](std::uint32_t group, std::uint32_t mask) {
            if (found.count < Found::most) {
                found.group[found.count] = group;
                found.mask[found.count] = mask;
            }
            ++found.count;
        });
        return found;
    }
    PIERCE_HD static std::uint32_t count(const Found& found) { return found.count; }
    PIERCE_HD void write(std::uint32_t i, const Found& found, std::uint32_t place,
                         RidgeNearGroup* near) const {
        const auto put = [&](std::uint32_t group, std::uint32_t mask) {
            near[place++] = {i, group, mask};
        };
        if (found.count > Found::most) return each(ridges[i], put);
        for (std::uint32_t k = 0; k < found.count; ++k) put(found.group[k], found.mask[k]);
    }

private:
    template <class See>
    PIERCE_HD void each(const NearRidge& ridge, const See& see) const {
        const DirectedPair& d = directed[ridge.directed];
        const BodyView &source = bodies[d.source], &target = bodies[d.target];
        const double margin = edge_margin_of(bodies, directed, ridge.directed);
        const Edge& edge = source.mesh.edges[ridge.edge];
        const Box reach = reach_of_ridge(source, d.to_space, edge, ridge.faces, margin, d.touch)
                              .inflated(passed_margin_of(marks, ridge.directed, margin, d.touch));
        for_each_group(target.box_nodes, BoxLevels(target.mesh.triangles.size),
                       boxes_along({source, d, edge}, target, margin, reach),
                       [&](std::uint32_t group, std::uint32_t mask) {
                           see(group, mask);
                           return false;
                       });
    }
};

/// An edge of the first body of a pair near an edge of the second.
struct NearEdgePair {
    std::uint32_t directed = 0;
    std::uint32_t edge = 0;
    std::uint32_t other_edge = 0;
    std::uint32_t triangle = 0;  ///< of the other edge, opposite to `corner`
    std::uint32_t corner = 0;
    std::uint32_t passed = 0;           ///< 1: the two have passed each other
    double along = 0, other_along = 0;  ///< the other edge runs as RidgeEnds has it
};

/// Per ridge and group: lists the edges of the group's triangles that it is near, where both are
/// ridges and closest to each other between their ends. Edges beside a triangle without area are
/// listed, too.
struct FindEdgePairs {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const NearRidge> ridges;
    View<const RidgeNearGroup> near;
    PairMarks marks;

    /// The sides of triangles at which the first pairs are.
    struct Found {
        static constexpr std::uint32_t most = 2;

        std::uint32_t count = 0;
        Ridge side[most];
    };

    PIERCE_HD Found find(std::uint32_t i) const {
        Found found;
        each(near[i], [&](const NearEdgePair& pair) {
            if (found.count < Found::most) found.side[found.count] = {pair.triangle, pair.corner};
            ++found.count;
        });
        return found;
    }
    PIERCE_HD static std::uint32_t count(const Found& found) { return found.count; }
    PIERCE_HD void write(std::uint32_t i, const Found& found, std::uint32_t place,
                         NearEdgePair* pairs) const {
        if (found.count == 0) return;
        const auto put = [&](const NearEdgePair& pair) { pairs[place++] = pair; };
        if (found.count > Found::most) return each(near[i], put);
        const RidgeQuery query = query_of(near[i]);
        for (std::uint32_t k = 0; k < found.count; ++k)
            query.at_side(found.side[k].triangle, found.side[k].corner, put);
    }

private:
    /// A ridge that looks at edges of the target.
    struct RidgeQuery {
        const BodyView& target;
        std::uint32_t directed = 0, edge = 0;
        double margin = 0, passed = 0, touch = 0;  ///< [length]; `passed`: as passed_margin_of()
        PlacedEdge placed;
        double largest = 0;  ///< coordinate of the target and of `placed`
        EdgeWedge wedge;

        /// The edge opposite to a corner, if it belongs to the triangle.
        template <class See>
        PIERCE_HD void at_side(std::uint32_t t, std::uint32_t corner, const See& see) const {
            const TriangleFeatures& features = target.mesh.features[t];
            // edge[k] joins k and the next corner
            const std::uint32_t k = corner == 2 ? 0 : corner + 1;
            if (!(features.own >> (3 + k) & 1u) || features.edge[k] == no_vertex) return;
            const RidgeEnds ends(target.surface(), {t, corner});
            if (!may_meet(t, corner, ends)) return;
            const SegmentPlaces places = closest_points_of_segments(placed.a, placed.b, ends.from,
                                                                    ends.to);
            if (!(places.first > 0 && places.first < 1 && places.second > 0 && places.second < 1))
                return;
            const Vec3d from = placed.a + places.first * (placed.b - placed.a),
                        to = ends.from + places.second * (ends.to - ends.from), way = to - from;
            if (!(length(way) < margin)) return;
            Vec3d direction = wedge.direction_to(way, placed.b - placed.a, ends.to - ends.from);
            if (!(length_squared(direction) > 0)) return;
            const bool have_passed = !wedge.faces(direction) && length(way) <= passed;
            if (have_passed) direction = -direction;
            if (!wedge.faces(direction)) return;
            const Edge& other = target.mesh.edges[features.edge[k]];
            const EdgeFaces faces = EdgeFaces::as_given(target.mesh, other);
            if (!faces.exist() || (!is_beside_thin(ends, faces) &&
                                   !(is_ridge(target, other, faces, touch) &&
                                     EdgeWedge(target, {}, other, faces, touch).faces(-direction))))
                return;
            see({directed, edge, features.edge[k], t, corner, have_passed, places.first,
                 places.second});
        }

        /// False if the edges are certainly not closest to each other between their ends, within
        /// the margin and with each one in the other's wedge.
        PIERCE_HD bool may_meet(std::uint32_t t, std::uint32_t corner,
                                const RidgeEnds& ends) const {
            const WayBetween way(placed.a, placed.b, ends.from, ends.to, largest);
            if (!way.is_known()) return true;
            const auto over = [&] {
                return to_double(target.positions[target.mesh.triangles[t].vertex[corner]]) -
                       ends.from;
            };
            const auto may_be = [&](const WayBetween& out, double most) {
                return !out.is_longer_than(most) && !wedge.excludes(out) &&
                       (may_have_thin(target) || !out.leads_over(over(), -1, touch));
            };
            return may_be(way, margin) || (passed > 0 && may_be(way.reversed(), passed));
        }

        PIERCE_HD bool is_beside_thin(const RidgeEnds& ends, const EdgeFaces& faces) const {
            const auto is_thin = [&](int k) {
                return is_degenerate(ends.from, ends.to,
                                     to_double(target.positions[faces.opposite[k]]));
            };
            return may_have_thin(target) && (is_thin(0) || is_thin(1));
        }
    };

    PIERCE_HD RidgeQuery query_of(const RidgeNearGroup& item) const {
        const NearRidge& ridge = ridges[item.ridge];
        const DirectedPair& d = directed[ridge.directed];
        const BodyView& source = bodies[d.source];
        const Edge& edge = source.mesh.edges[ridge.edge];
        const PlacedEdge placed(source, d, edge);
        Box around = positions_box(bodies[d.target]);
        around.extend(placed.a);
        around.extend(placed.b);
        const double margin = edge_margin_of(bodies, directed, ridge.directed);
        return {bodies[d.target],
                ridge.directed,
                ridge.edge,
                margin,
                passed_margin_of(marks, ridge.directed, margin, d.touch),
                d.touch,
                placed,
                around.max_coordinate(),
                {source, d.to_space, edge, ridge.faces, d.touch}};
    }

    template <class See>
    PIERCE_HD void each(const RidgeNearGroup& item, const See& see) const {
        const RidgeQuery query = query_of(item);
        for (std::uint32_t mask = item.mask; mask != 0; mask &= mask - 1) {
            const std::uint32_t
                t = query.target.mesh
                        .group_triangles[item.group * constants::group_size + lowest_bit(mask)];
            for (std::uint32_t corner = 0; corner < 3; ++corner) query.at_side(t, corner, see);
        }
    }

    static_assert(sizeof(NearEdgePair) == 40);
};

}  // namespace pierce::stages
