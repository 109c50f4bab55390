#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/geometry/closest_points_of_segments.hpp"
#include "core/mesh/box_nodes.hpp"
#include "core/mesh/edge_group.hpp"
#include "core/mesh/edge_normal.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/margin/margin_stages.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/ray.hpp"
#include "pierce/constants.hpp"

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
        for (std::uint32_t b = 0; b < found; ++b) blocks[place + b] = {i, b};
    }
};

/// Where a pair's edges are, for spheres around edges of the rest shape.
PIERCE_HD inline EdgePlace margin_place(View<const BodyView> bodies,
                                        View<const DirectedPair> directed,
                                        std::uint32_t direction) {
    EdgePlace place(bodies, directed, direction, false);
    place.margin += edge_margin_of(bodies, directed, direction);
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
                                  block.radius, static_cast<double>(block.reach), place.margin);
        return balls.near & first_bits(edge_block_length(mesh, item.index));
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t mask, std::uint32_t place,
                         CullItem* groups) const {
        for (; mask != 0; mask &= mask - 1)
            groups[place++] = {blocks[i].directed,
                               blocks[i].index * constants::block_size + lowest_bit(mask)};
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
            static_cast<double>(block.radius[item.index % constants::block_size]), place.margin);
        return balls.near & first_bits(edge_group_length(mesh, item.index));
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t mask) { return bit_count(mask); }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t mask, std::uint32_t place,
                         CullItem* edges) const {
        for (; mask != 0; mask &= mask - 1)
            edges[place++] = {groups[i].directed,
                              groups[i].index * constants::group_size + lowest_bit(mask)};
    }
};

/// An edge of the first body of a pair near an edge of the second.
struct NearEdgePair {
    std::uint32_t directed = 0;
    std::uint32_t edge = 0;
    std::uint32_t other_edge = 0;
    std::uint32_t triangle = 0;  ///< of the other edge, opposite to `corner`
    std::uint32_t corner = 0;
    std::uint32_t padding = 0;
    double along = 0, other_along = 0;  ///< the other edge runs as RidgeEnds has it
};

/// An edge between two triangles that bend away from each other outward, in the space of a target:
/// what is nearest to it lies in the wedge of their normals.
class ConvexEdge {
public:
    PIERCE_HD ConvexEdge(const BodyView& body, const Frame& to_space, const Edge& edge,
                         double touch)
        : touch_(touch) {
        if (edge.triangle[1] == no_triangle) return;
        const auto at = [&](std::uint32_t v) {
            return to_space.to_parent(to_double(body.positions[v]));
        };
        from_ = at(edge.vertex[0]);
        const Vec3d along = normalized(at(edge.vertex[1]) - from_);
        for (int k = 0; k < 2; ++k) {
            const Triangle& t = body.mesh.triangles[edge.triangle[k]];
            for (std::uint32_t v : t.vertex)
                if (v != edge.vertex[0] && v != edge.vertex[1]) opposite_[k] = at(v);
        }
        for (int k = 0; k < 2; ++k)
            normal_[k] = to_space.rotation *
                         triangle_normal(body.mesh, body.positions, edge.triangle[k]);
        bends_ = dot(normal_[0], opposite_[1] - from_) < -touch;
        for (int k = 0; k < 2; ++k)
            slack_ = max_of(slack_, touch / length(cross(opposite_[k] - from_, along)));
    }

    PIERCE_HD bool bends() const { return bends_; }

    /// False if a segment is behind both triangles: then no place of it lies in the wedge.
    PIERCE_HD bool may_face(Vec3d from, Vec3d to) const {
        for (const Vec3d& normal : normal_)
            if (max_of(dot(normal, from - from_), dot(normal, to - from_)) > -touch_) return true;
        return false;
    }

    /// Around all ways from the edge that faces() is true for and that are not longer than
    /// `margin`. Directions between two normals are within the triangle of both and of where the
    /// tangents there meet.
    PIERCE_HD Box reach(double margin) const {
        Box box;
        const double cosine = dot(normal_[0], normal_[1]);
        // Where the edge is sharp or a triangle thin, that triangle is large, or not certain.
        if (!(cosine > constants::wedge_cosine) || !(slack_ < constants::wedge_slack)) {
            const Vec3d all{margin, margin, margin};
            return {-all, all};
        }
        box.extend(Vec3d{});
        for (const Vec3d& normal : normal_) box.extend(margin * normal);
        box.extend(margin / (1 + cosine) * (normal_[0] + normal_[1]));
        return box.inflated(2 * slack_ * margin + touch_);
    }

    /// True if `direction`, unit, from a point of the edge and at right angles to it, leads away
    /// from both triangles.
    PIERCE_HD bool faces(Vec3d direction) const {
        return bends_ && dot(direction, opposite_[0] - from_) <= touch_ &&
               dot(direction, opposite_[1] - from_) <= touch_;
    }

private:
    double touch_;
    double slack_ = 0;  ///< the sine of the angle by which faces() lets directions differ
    Vec3d from_, opposite_[2], normal_[2];
    bool bends_ = false;
};

/// Per edge: lists the edges of the other body that it is near, where both are ridges and closest
/// to each other between their ends.
struct FindEdgePairs {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> edges;

    PIERCE_HD std::uint32_t find(std::uint32_t i) const {
        std::uint32_t found = 0;
        each(edges[i], [&](const NearEdgePair&) { ++found; });
        return found;
    }
    PIERCE_HD static std::uint32_t count(std::uint32_t found) { return found; }
    PIERCE_HD void write(std::uint32_t i, std::uint32_t found, std::uint32_t place,
                         NearEdgePair* pairs) const {
        if (found > 0) each(edges[i], [&](const NearEdgePair& pair) { pairs[place++] = pair; });
    }

private:
    template <class See>
    PIERCE_HD void each(const CullItem& item, const See& see) const {
        const DirectedPair& d = directed[item.directed];
        const BodyView &source = bodies[d.source], &target = bodies[d.target];
        const double margin = edge_margin_of(bodies, directed, item.directed);
        const Edge& edge = source.mesh.edges[item.index];
        const ConvexEdge ridge(source, d.to_space, edge, d.touch);
        const PlacedEdge placed(source, d, edge);
        if (!ridge.bends() ||
            (target.mesh.slabs.size > 0 && proof_of(source, target, placed).gap > margin + d.touch))
            return;
        for_each_group(
            target.box_nodes, BoxLevels(target.mesh.triangles.size),
            boxes_along(placed, target, margin, ridge.reach(margin)),
            [&](std::uint32_t group, std::uint32_t mask) {
                for (; mask != 0; mask &= mask - 1) {
                    const std::uint32_t
                        t = target.mesh
                                .group_triangles[group * constants::group_size + lowest_bit(mask)];
                    for (std::uint32_t corner = 0; corner < 3; ++corner)
                        look(item, placed, ridge, target, t, corner, margin, d.touch, see);
                }
                return false;
            });
    }

    /// The edge opposite to a corner, if it belongs to the triangle.
    template <class See>
    PIERCE_HD static void look(const CullItem& item, const PlacedEdge& placed,
                               const ConvexEdge& ridge, const BodyView& target, std::uint32_t t,
                               std::uint32_t corner, double margin, double touch, const See& see) {
        const TriangleFeatures& features = target.mesh.features[t];
        const std::uint32_t side = corner == 2 ? 0 : corner + 1;  // edge[k] joins k and the next
        if (!(features.own >> (3 + side) & 1u) || features.edge[side] == no_vertex) return;
        const RidgeEnds ends(target.surface(), {t, corner});
        if (!ridge.may_face(ends.from, ends.to)) return;
        const SegmentPlaces places = closest_points_of_segments(placed.a, placed.b, ends.from,
                                                                ends.to);
        if (!(places.first > 0 && places.first < 1 && places.second > 0 && places.second < 1))
            return;
        const Vec3d from = placed.a + places.first * (placed.b - placed.a),
                    to = ends.from + places.second * (ends.to - ends.from), way = to - from;
        const double distance = length(way);
        if (!(distance > touch && distance < margin)) return;
        const Vec3d direction = (1 / distance) * way;
        const Edge& other = target.mesh.edges[features.edge[side]];
        if (!ridge.faces(direction) || !ConvexEdge(target, {}, other, touch).faces(-direction))
            return;
        see({item.directed, item.index, features.edge[side], t, corner, 0, places.first,
             places.second});
    }

    static_assert(sizeof(NearEdgePair) == 40);
};

/// Per pair of edges: a chord that stands for the point of the first one, and a contact that is not
/// deep. Both join the step's.
struct JoinEdgePairs {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const NearEdgePair> pairs;
    Number first_chord;
    View<Chord> chords;
    JoinBatch batch;  ///< from_... are not read

    PIERCE_HD void operator()(std::uint32_t i) const {
        const NearEdgePair& pair = pairs[i];
        const DirectedPair& d = directed[pair.directed];
        const BodyView& target = bodies[d.target];
        const PlacedEdge placed(bodies[d.source], d, bodies[d.source].mesh.edges[pair.edge]);
        const RidgeEnds ends(target.surface(), {pair.triangle, pair.corner});
        const Vec3d from = placed.a + pair.along * (placed.b - placed.a),
                    to = ends.from + pair.other_along * (ends.to - ends.from);
        chords[first_chord + i] = {.edge = pair.edge,
                                   .ordinal = pair.other_edge,
                                   .along = pair.along,
                                   .skin = 0,
                                   .ridge = {pair.triangle, pair.corner},
                                   .begin = {},
                                   .end = {}};
        Ray ray;
        ray.origin = from;
        ray.direction = normalized(from - to);
        ray.target = d.target;
        ray.touch = d.touch;
        Meeting meeting;
        meeting.t = -length(to - from);
        meeting.barycentric[pair.corner] = 0;
        meeting.barycentric[pair.corner == 2 ? 0 : pair.corner + 1] = 1 - pair.other_along;
        meeting.barycentric[pair.corner == 0 ? 2 : pair.corner - 1] = pair.other_along;
        meeting.exit = true;
        batch.put(i, ray,
                  {.pair = pair.directed / 2,
                   .item = first_chord + i,
                   .side = static_cast<std::uint8_t>(pair.directed % 2),
                   .start = RayStart::chord,
                   .is_near = true},
                  {pair.triangle}, meeting, true);
    }
};

}  // namespace pierce::stages
