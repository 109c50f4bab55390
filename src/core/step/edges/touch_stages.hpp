#pragma once

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/chord_stages.hpp"
#include "core/step/edges/edge_cull.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "pierce/min_max.hpp"

/// edges of pairs whose edges only touch: cast again as if one body had moved a little.
namespace pierce::stages {

/// True for segments of pairs whose edges touch, and that have no contact so far.
struct OnlyTouches {
    View<const EdgeItem> items;
    View<const Segment> segments;
    View<const std::uint32_t> touching, contact;  ///< per pair

    PIERCE_HD bool operator()(std::uint32_t i) const {
        const std::uint32_t pair = items[segments[i].item].directed / 2;
        return touching[pair] && !contact[pair];
    }
};

/// [length] How far the bodies of a pair are moved against each other, if their edges only touch.
PIERCE_HD inline double nudge_of(View<const DirectedPair> directed, std::uint32_t direction) {
    return constants::nudge * touch_of_pair(directed, direction);
}

/// Per segment to be cast again: its ray, as if one body of the pair had moved a little. Edges that
/// lay in the other body's surface then lie inside or outside of it. If two bodies overlap, some
/// edge of one crosses the other.
struct NudgeSegment {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeItem> items;
    View<const Span> spans;
    View<const std::uint32_t> again;  ///< places in segments and rays
    double sign = 1;                  ///< of the move
    View<Segment> segments;
    View<Ray> rays;

    PIERCE_HD void operator()(std::uint32_t k) const {
        const std::uint32_t i = again[k];
        const EdgeItem item = items[segments[i].item];
        const DirectedPair& d = directed[item.directed];
        const BodyView& source = bodies[d.source];
        // A device can use an array of constants only in what the compiler evaluates.
        constexpr Vec3d along{constants::nudge_direction[0], constants::nudge_direction[1],
                              constants::nudge_direction[2]};
        const Vec3d move = (item.directed % 2 == 0 ? sign : -sign) *
                           nudge_of(directed, item.directed) * along;
        const Edge& edge = source.mesh.edges[item.edge];
        Ray& ray = rays[i];
        ray.origin = d.to_space.to_parent(to_double(source.positions[edge.vertex[0]])) +
                     spans[segments[i].item].begin * ray.direction +
                     bodies[d.target].space.rotation.transposed() * move;
        ray.t_min = 0;
        segments[i].enter = 0;
        segments[i].crossed = segments[i].inside = false;
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
    const Vec3d start = point_on(source, edge, chord.middle),
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

private:
    PIERCE_HD bool leaves(std::uint32_t ray) const {
        return rays[ray].t_max < 0 ? otherwise : LeavesTarget{bodies, rays, hits}(ray);
    }
};

/// Per chord of a nudged edge: its rays. Reads the edge at its true place.
struct GenerateTouchRays {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeItem> items;
    View<const Segment> segments;
    View<FoundChord> found;
    View<Ray> rays;  ///< two per chord

    PIERCE_HD void operator()(std::uint32_t i) const {
        FoundChord& f = found[i];
        const std::uint32_t direction = items[segments[f.segment].item].directed;
        f.chord.skin = constants::skin * touch_of_pair(directed, direction);
        write_inside_rays(bodies, directed[direction], f.chord, f.chord.skin, rays[2 * i],
                          rays[2 * i + 1]);
    }
};

/// Per chord of a nudged edge that shows an overlap: joins the step's chords.
struct KeepTouch {
    View<const EdgeItem> items;
    View<const Segment> segments;
    View<const FoundChord> found;
    View<const std::uint32_t> places;  ///< in `found`
    std::uint32_t begin = 0;           ///< chords there are already
    View<Chord> chords;
    View<RaySource> sources;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const FoundChord& f = found[places[i]];
        const std::uint32_t directed = items[segments[f.segment].item].directed;
        chords[begin + i] = f.chord;
        sources[i] = {.pair = directed / 2,
                      .item = begin + i,
                      .side = static_cast<std::uint8_t>(directed % 2),
                      .start = RayStart::chord};
    }
};

}  // namespace pierce::stages
