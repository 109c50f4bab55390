#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/chord_stages.hpp"
#include "core/step/edges/near_edge.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/directed_pair.hpp"

/// edges of pairs whose edges only touch: looked at again as if one body had moved a little. Edges
/// that lay in the other body's surface then lie inside or outside of it. If two bodies overlap,
/// some edge of one crosses the other.
namespace pierce::stages {

/// True for edges of pairs whose edges touch, and that have no contact so far; not for edges that
/// are proved to cross nothing, even if they are moved.
struct OnlyTouches {
    View<const DirectedPair> directed;
    View<const NearEdge> near;
    PairMarks marks;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        const NearEdge& edge = near[i];
        const std::uint32_t pair = edge.directed / 2;
        return marks.any(pair, PairMarks::edge_touches) &&
               !marks.any(pair, PairMarks::in_contact | PairMarks::moved_overlaps) &&
               (edge.crosses != no_triangle || !(edge.expiry > directed[edge.directed].odometer));
    }
};

/// The rays from a chord's middle, between its edge's triangles, that show whether the target and
/// the source have an inside there. Crossings within `skin` [length] do not count, so that bodies
/// which only touch share no inside.
PIERCE_HD inline void write_inside_rays(View<const BodyView> bodies, const DirectedPair& d,
                                        const Chord& chord, double skin, Ray& into_target,
                                        Ray& into_source) {
    const BodyView& source = bodies[d.source];
    const Edge& edge = source.mesh.edges[chord.edge];
    const Vec3d start = point_on(source, edge, chord.along),
                direction = inward_direction(source, edge);
    const bool leads = length_squared(direction) > 0;
    into_target = into_source = {};
    into_target.t_min = into_source.t_min = skin;
    into_target.origin = d.to_space.to_parent(start);
    into_target.direction = normalized(d.to_space.rotation * direction);
    into_target.t_max = leads ? bodies[d.target].fit_box.extent() : -1.0;
    into_target.target = d.target;
    into_target.touch = d.touch;
    into_source.origin = start;
    into_source.direction = direction;
    const bool has_inside = source.is_solid() && source.mesh.simple;
    into_source.t_max = leads && has_inside ? source.fit_box.extent() : -1.0;
    into_source.target = d.source;
    into_source.touch = source.touch;
}

/// True for chords whose two rays leave both bodies: the bodies overlap there. A ray that is not
/// traced counts as `otherwise`.
struct LeavesBoth {
    View<const BodyView> bodies;
    View<const Ray> rays;  ///< two per chord
    View<const Hit> hits;
    bool otherwise = true;

    PIERCE_HD bool operator()(std::uint32_t i) const { return leaves(2 * i) && leaves(2 * i + 1); }

    /// True if the target's ray is traced: it is not where the edge has no inward direction.
    PIERCE_HD bool has_way(std::uint32_t i) const { return !(rays[2 * i].t_max < 0); }
    /// [length] How far both rays of a chord get inside, if they leave both bodies.
    PIERCE_HD double way(std::uint32_t i) const {
        const LeavesTarget target{bodies, rays, hits};
        const double in_target = target.way(2 * i);
        return rays[2 * i + 1].t_max < 0 ? in_target : min_of(in_target, target.way(2 * i + 1));
    }

private:
    PIERCE_HD bool leaves(std::uint32_t ray) const {
        return rays[ray].t_max < 0 ? otherwise : LeavesTarget{bodies, rays, hits}(ray);
    }
};

/// Per chord of a nudged edge: its rays. Reads the edge at its true place.
struct GenerateTouchRays {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<FoundChord> found;
    View<Ray> rays;  ///< two per chord

    PIERCE_HD void operator()(std::uint32_t i) const {
        FoundChord& f = found[i];
        f.chord.skin = constants::skin * touch_of_pair(directed, f.directed);
        write_inside_rays(bodies, directed[f.directed], f.chord, f.chord.skin, rays[2 * i],
                          rays[2 * i + 1]);
    }
};

}  // namespace pierce::stages
