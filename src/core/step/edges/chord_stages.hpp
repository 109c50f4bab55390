#pragma once

#include "core/body/body_view.hpp"
#include "core/device/atomics.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/edge_cull.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/min_max.hpp"

/// edges, second part: which parts of the edges are inside the other body (their chords), and a ray
/// from the middle of each.
namespace pierce::stages {

/// A chord as it is found, in the order of the rounds.
struct FoundChord {
    std::uint32_t segment = 0;
    Chord chord;
};

/// Per active segment: takes its next crossing into account. Reads rays and hits; writes at most
/// one chord, and whether there may be more.
struct AdvanceSegment {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeItem> items;
    View<const Span> spans;
    View<const std::uint32_t> active;
    View<const Hit> hits;  ///< per active segment
    View<Segment> segments;
    View<Ray> rays;                ///< per segment
    View<std::uint32_t> counts;    ///< per active segment: chords found now
    View<FoundChord> found;        ///< per active segment, where there is one
    View<std::uint32_t> finished;  ///< per segment
    View<std::uint32_t> touching;  ///< per pair: marked where an edge touches the surface

    PIERCE_HD void operator()(std::uint32_t k) const {
        const std::uint32_t i = active[k];
        Segment& segment = segments[i];
        Ray& ray = rays[i];
        counts[k] = 0;
        finished[i] = 1;
        if (hits[k].grazed) mark_touching(i);
        if (hits[k].triangle == no_triangle) {
            if (segment.inside) add(k, segment.enter, ray.t_max);
            return;
        }
        const Meeting m = meet(ray, bodies[ray.target].surface(), hits[k].triangle);
        if (m.exit && (segment.inside || !segment.crossed))
            add(k, segment.enter, min_of(m.t, ray.t_max));
        segment.crossed = true;
        segment.inside = !m.exit;
        segment.enter = m.t;
        ray.t_min = m.t + ray.touch;
        finished[i] = !(ray.t_min < ray.t_max);
        if (finished[i] && segment.inside) add(k, segment.enter, ray.t_max);
    }

private:
    PIERCE_HD void add(std::uint32_t k, double begin, double end) const {
        const std::uint32_t i = active[k];
        if (!(end - begin > rays[i].touch)) return mark_touching(i);
        const std::uint32_t item = segments[i].item;
        const BodyView& source = bodies[directed[items[item].directed].source];
        const Edge& edge = source.mesh.edges[items[item].edge];
        const double size = length(to_double(source.positions[edge.vertex[1]]) -
                                   to_double(source.positions[edge.vertex[0]]));
        const double middle = (spans[item].begin + 0.5 * (begin + end)) / size;
        counts[k] = 1;
        found[k] = {i, {items[item].edge, segments[i].chords++, clamp_to(middle, 0.0, 1.0), 0.0}};
    }

    PIERCE_HD void mark_touching(std::uint32_t i) const {
        atomic_mark(touching[items[segments[i].item].directed / 2]);
    }
};

/// True for active segments that may have more crossings.
struct GoesOn {
    View<const std::uint32_t> active, finished;

    PIERCE_HD bool operator()(std::uint32_t k) const { return !finished[active[k]]; }
};

/// Per active segment: moves the chord found in this round to the list of all.
struct KeepChord {
    View<const std::uint32_t> counts, offsets;
    View<const FoundChord> found;
    std::uint32_t begin = 0;  ///< chords of earlier rounds
    View<FoundChord> chords;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t k) const {
        if (counts[k]) chords[begin + offsets[k]] = found[k];
    }
};

/// Per chord: a key that puts chords in the order of edges, those of one edge as they were found.
struct KeyChord {
    View<const FoundChord> found;
    View<std::uint64_t> keys;
    View<std::uint32_t> order;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        keys[i] = found[i].segment;
        order[i] = i;
    }
};

/// Per chord, in the order of edges: the ray from its middle, inward. Reads chords and segments;
/// appends to the step's rays.
struct GenerateChordRays {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeItem> items;
    View<const Segment> segments;
    View<const FoundChord> found;
    View<const std::uint32_t> order;
    std::uint32_t begin = 0;  ///< rays there are already
    View<Chord> chords;
    View<Ray> rays;
    View<RaySource> sources;
    View<Hit> hits;
    View<Route> routes;  ///< empty if steps do not remember

    PIERCE_HD void operator()(std::uint32_t i) const {
        const FoundChord& f = found[order[i]];
        const EdgeItem item = items[segments[f.segment].item];
        const DirectedPair& d = directed[item.directed];
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        const Edge& edge = source.mesh.edges[item.edge];
        const Vec3d start = point_on(source, edge, f.chord.middle);
        const Vec3d direction = inward_direction(source, edge);
        Ray ray;
        ray.origin = d.to_space.to_parent(start);
        ray.direction = normalized(d.to_space.rotation * direction);
        ray.t_max = source.mesh.closed ? range_in_boxes(source, target, start, direction)
                                       : source.range;
        if (!(length_squared(direction) > 0)) ray.t_max = -1.0;
        ray.target = d.target;
        ray.touch = d.touch;
        const std::uint32_t slot = begin + i;
        chords[i] = f.chord;
        rays[slot] = ray;
        sources[slot] = {.pair = item.directed / 2,
                         .item = i,
                         .side = static_cast<std::uint8_t>(item.directed % 2),
                         .start = RayStart::chord};
        hits[slot] = {};
        if (routes.size > 0) routes[slot] = ray.t_max >= 0 ? Route::full : Route::skip;
    }
};

}  // namespace pierce::stages
