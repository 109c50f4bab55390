#pragma once

#include "core/body/body_view.hpp"
#include "core/device/number.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/margin/covered_ridge.hpp"
#include "core/step/margin/edge_wedge.hpp"
#include "core/step/margin/near_edge_pairs.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/join_batch.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/ray.hpp"
#include "core/trace/ridge.hpp"

/// margin, last part: pairs of edges become contacts.
namespace pierce::stages {

/// True for a ridge of the union of a body's parts, if a place on it, from which `out` leads away,
/// is closest to what is there.
PIERCE_HD inline bool is_faced(const BodyView& body, std::uint32_t edge, Vec3d place, Vec3d out,
                               double touch) {
    const Edge& ridge = body.mesh.edges[edge];
    const EdgeFaces faces(body, ridge);
    return is_ridge(body, ridge, faces, touch) &&
           EdgeWedge(body, {}, ridge, faces, touch).faces(out) &&
           !is_covered(body, faces, place, out);
}

/// Per pair of edges: a chord that stands for the point of the first one, and a contact, if both
/// are ridges of their solids there. Both join the step's.
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
        const BodyView &source = bodies[d.source], &target = bodies[d.target];
        const PlacedEdge placed(source, d, source.mesh.edges[pair.edge]);
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
        const Edge& edge = source.mesh.edges[pair.edge];
        const EdgeWedge wedge(source, d.to_space, edge, EdgeFaces(source, edge), d.touch);
        const Vec3d way = wedge.direction_to(to - from, placed.b - placed.a, ends.to - ends.from);
        ray.direction = pair.passed ? way : -way;
        ray.target = d.target;
        ray.touch = d.touch;
        Meeting meeting;
        const double distance = length(to - from);
        meeting.t = !(distance > d.touch) ? 0.0 : pair.passed ? distance : -distance;
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
                  {pair.triangle}, meeting,
                  is_faced(target, pair.other_edge, to, ray.direction, d.touch) &&
                      !lies_in_other_part(source, pair.edge, d.to_space, from, -ray.direction));
    }

private:
    /// True if a place on a ridge, in the target's space, lies in another part of its body.
    PIERCE_HD static bool lies_in_other_part(const BodyView& body, std::uint32_t edge,
                                             const Frame& to_space, Vec3d place, Vec3d out) {
        return body.mesh.covered.size > 0 &&
               is_covered(body, EdgeFaces(body, body.mesh.edges[edge]), to_space.to_local(place),
                          to_space.rotation.transposed() * out);
    }
};

}  // namespace pierce::stages
