#pragma once

#include <utility>

#include "core/body/body_view.hpp"
#include "core/device/atomics.hpp"
#include "core/device/loops.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/classify.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/vertex_cull.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/min_max.hpp"

/// Stages 4 and 5 for edges, with complete coverage: which edges may reach the other body, which
/// parts of them are inside it (their chords), and a ray from the middle of each. If the surfaces
/// of two closed bodies cross, an edge of one of them crosses the other: vertices alone may miss
/// that.
namespace pierce::stages {

/// Per block: a bit for every patch with an edge that may reach the target, and their number.
struct CullEdgeBlock {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> blocks;
    View<std::uint32_t> masks, counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[blocks[i].directed];
        masks[i] = counts[i] = 0;
        if (d.is_self())
            return;  // of a body itself, vertices alone are looked at; a sheet has no clearance
                     // either
        const BodyView& source = bodies[d.source];
        const std::uint32_t b = blocks[i].index, count = block_length(source.mesh, b);
        const PatchBlock& block = source.blocks[b];
        // An edge starts in its patch's ball and is as long as in the rest shape, but for the
        // deviation of its two ends.
        float radius[constants::block_size] = {};
        float longest_edge = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            const float edge = source.mesh.edge_reach[b * constants::block_size + k];
            radius[k] = block.radius[k] + edge;
            longest_edge = max_of(edge, longest_edge);
        }
        const double span = static_cast<double>(block.reach) + static_cast<double>(longest_edge);
        const BallsNearby<> balls(bodies[d.target], d.to_fit, block.center, block.offsets, radius,
                                  span, 2 * source.deviation + constants::touch_tolerance * span);
        masks[i] = balls.near & first_bits(count);
        counts[i] = bit_count(masks[i]);
    }
};

/// Per block: lists the patches it keeps. Reads masks and offsets.
struct ListEdgePatches {
    View<const CullItem> blocks;
    View<const std::uint32_t> masks, offsets;
    View<CullItem> patches;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        std::uint32_t slot = offsets[i];
        for (std::uint32_t mask = masks[i]; mask != 0; mask &= mask - 1)
            patches[slot++] = {blocks[i].directed,
                               blocks[i].index * constants::block_size + lowest_bit(mask)};
    }
};

/// A few edges of a directed pair's source, one after the other.
struct EdgeGroup {
    std::uint32_t directed = 0;
    std::uint32_t first = 0;
    std::uint32_t count = 0;  ///< Offsets::count at most
};

/// Per kept patch: how many groups of edges it has.
struct CountEdgeGroups {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> patches;
    View<std::uint32_t> counts;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const MeshView& mesh = bodies[directed[patches[i].directed].source].mesh;
        const std::uint32_t edges = mesh.edge_offsets[patches[i].index + 1] -
                                    mesh.edge_offsets[patches[i].index];
        counts[i] = (edges + Offsets::count - 1) / Offsets::count;
    }
};

/// Per kept patch: lists its groups.
struct ListEdgeGroups {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const CullItem> patches;
    View<const std::uint32_t> offsets;
    View<EdgeGroup> groups;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const MeshView& mesh = bodies[directed[patches[i].directed].source].mesh;
        const std::uint32_t last = mesh.edge_offsets[patches[i].index + 1];
        std::uint32_t slot = offsets[i];
        for (std::uint32_t e = mesh.edge_offsets[patches[i].index]; e < last; e += Offsets::count)
            groups[slot++] = {patches[i].directed, e, min_of(Offsets::count, last - e)};
    }
};

/// Per group: a bit for every edge whose ball, around its middle and as wide as it is long, may
/// reach the target.
struct CullEdgeGroup {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeGroup> groups;
    View<std::uint32_t> masks, counts;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const EdgeGroup group = groups[i];
        const DirectedPair& d = directed[group.directed];
        const BodyView& source = bodies[d.source];
        const Vec3d center = to_double(source.positions[source.mesh.edges[group.first].vertex[0]]);
        const Vec3f c = to_float(center);  // a position: nothing is lost
        Offsets middles, halves;
        for (std::uint32_t k = 0; k < group.count; ++k) {
            const Edge& edge = source.mesh.edges[group.first + k];
            const Vec3f a = source.positions[edge.vertex[0]] - c,
                        b = source.positions[edge.vertex[1]] - c;
            middles.set(k, 0.5f * (a + b));
            halves.set(k, 0.5f * (b - a));
        }
        float radius[Offsets::count], span = 0;
        PIERCE_VECTOR_LOOP
        for (std::uint32_t k = 0; k < Offsets::count; ++k)
            radius[k] = std::sqrt(halves.x[k] * halves.x[k] + halves.y[k] * halves.y[k] +
                                  halves.z[k] * halves.z[k]);
        for (std::uint32_t k = 0; k < group.count; ++k) span = max_of(radius[k], span);
        const double reach = static_cast<double>(longest(middles)) + static_cast<double>(span);
        const BallsNearby<> balls(bodies[d.target], d.to_fit, center, middles, radius, reach,
                                  constants::touch_tolerance * reach);
        masks[i] = balls.near & first_bits(group.count);
        counts[i] = bit_count(masks[i]);
    }
};

/// An edge of a directed pair's source.
struct EdgeItem {
    std::uint32_t directed = 0;
    std::uint32_t edge = 0;
};

/// Per group: lists the edges it keeps.
struct ListEdges {
    View<const EdgeGroup> groups;
    View<const std::uint32_t> masks, offsets;
    View<EdgeItem> items;

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        std::uint32_t slot = offsets[i];
        for (std::uint32_t mask = masks[i]; mask != 0; mask &= mask - 1)
            items[slot++] = {groups[i].directed, groups[i].first + lowest_bit(mask)};
    }
};

/// A part of a segment by distances from its first end [length]; empty if it ends before it begins.
struct Span {
    double begin = 0, end = -1;

    PIERCE_HD bool empty() const { return end < begin; }
};

/// What is left of the segment from `a` to `b`, given in the target's fit frame, without the parts
/// at both ends that are certainly outside of the target's solid: marches inward by the distance
/// proved at each place.
PIERCE_HD inline Span part_near(const BodyView& target, Vec3d a, Vec3d b) {
    const double size = length(b - a);
    const Vec3d direction = normalized(b - a);
    const auto free = [&](double at) {
        const Vec3d p = a + at * direction;
        return max_of(target.fit_box.distance(p), target.mesh.clearance()(p) - target.deviation) -
               2 * target.touch;
    };
    Span span{0, size};
    if (size > 0 && size < constants::march_cells * target.mesh.clearance_at.cell) return span;
    // A step that rounding swallows is the last one.
    for (double step;
         (step = free(span.begin)) > constants::march_share * (span.end - span.begin);) {
        const double before = std::exchange(span.begin, span.begin + step);
        if (span.empty() || !(span.begin > before)) return span;
    }
    for (double step; (step = free(span.end)) > constants::march_share * (span.end - span.begin);) {
        const double before = std::exchange(span.end, span.end - step);
        if (span.empty() || !(span.end < before)) return span;
    }
    return span;
}

/// Per edge: the part of it that may be inside the target.
struct CullEdge {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeItem> items;
    View<Span> spans;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const DirectedPair& d = directed[items[i].directed];
        const BodyView& source = bodies[d.source];
        const Edge& edge = source.mesh.edges[items[i].edge];
        spans[i] = part_near(bodies[d.target],
                             d.to_fit.to_parent(to_double(source.positions[edge.vertex[0]])),
                             d.to_fit.to_parent(to_double(source.positions[edge.vertex[1]])));
    }
};

/// True for edges with a part that may be inside the target.
struct MayReach {
    View<const Span> spans;

    PIERCE_HD bool operator()(std::uint32_t i) const { return !spans[i].empty(); }
};

/// What is known of an edge so far, from one crossing to the next.
struct Segment {
    std::uint32_t item = 0;
    std::uint32_t chords = 0;  ///< found so far
    double enter = 0;          ///< [length] along the ray, where it was last entered
    bool crossed = false;      ///< at least once
    bool inside = false;       ///< beyond the last crossing
    std::uint8_t padding[6] = {};
};

/// Per edge that may reach its target: the ray along it.
struct GenerateSegments {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeItem> items;
    View<const Span> spans;
    View<const std::uint32_t> slots;  ///< places in items and spans
    View<Segment> segments;
    View<Ray> rays;
    View<std::uint32_t> active;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t slot = slots[i];
        const DirectedPair& d = directed[items[slot].directed];
        const BodyView& source = bodies[d.source];
        const Edge& edge = source.mesh.edges[items[slot].edge];
        const Vec3d a = d.to_space.to_parent(to_double(source.positions[edge.vertex[0]]));
        const Vec3d b = d.to_space.to_parent(to_double(source.positions[edge.vertex[1]]));
        Ray ray;
        ray.direction = normalized(b - a);
        ray.origin = a + spans[slot].begin * ray.direction;
        ray.t_max = length_squared(ray.direction) > 0 ? spans[slot].end - spans[slot].begin : -1.0;
        ray.target = d.target;
        rays[i] = ray;
        segments[i] = {};
        segments[i].item = slot;
        active[i] = i;
    }
};

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
        const Surface surface = bodies[ray.target].surface();
        counts[k] = 0;
        finished[i] = 1;
        if (hits[k].grazed) mark_touching(i);
        if (hits[k].triangle == no_triangle) {
            if (segment.inside) add(k, segment.enter, ray.t_max);
            return;
        }
        const Meeting m = meet(ray, surface, hits[k].triangle);
        if (m.exit && (segment.inside || !segment.crossed))
            add(k, segment.enter, min_of(m.t, ray.t_max));
        segment.crossed = true;
        segment.inside = !m.exit;
        segment.enter = m.t;
        ray.t_min = m.t + surface.touch;
        finished[i] = !(ray.t_min < ray.t_max);
        if (finished[i] && segment.inside) add(k, segment.enter, ray.t_max);
    }

private:
    PIERCE_HD void add(std::uint32_t k, double begin, double end) const {
        const std::uint32_t i = active[k];
        if (!(end - begin > bodies[rays[i].target].touch)) return mark_touching(i);
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
PIERCE_HD inline double nudge_of(View<const BodyView> bodies, const DirectedPair& d) {
    return constants::nudge * max_of(bodies[d.source].touch, bodies[d.target].touch);
}

/// Per segment to be cast again: its ray, as if one body of the pair had moved a little. Edges that
/// lay in the other's surface come to lie inside or outside then; of two bodies that overlap, some
/// edge crosses the other.
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
        // A device can read an array of constants only where the compiler does.
        constexpr Vec3d along{constants::nudge_direction[0], constants::nudge_direction[1],
                              constants::nudge_direction[2]};
        const Vec3d move = (item.directed % 2 == 0 ? sign : -sign) * nudge_of(bodies, d) * along;
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
/// the source have an inside there. What lies within `skin` [length] does not count, so that bodies
/// which only touch have none in common.
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
    into_source.origin = start;
    into_source.direction = direction;
    const bool has_inside = source.is_solid() && source.mesh.simple;
    into_source.t_max = leads && has_inside ? source.fit_box.extent() : -1.0;
    into_source.target = d.source;
}

/// True for chords whose two rays leave both bodies: they overlap there. A ray that is none says
/// `otherwise`.
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

/// Per chord of a nudged edge: its rays. Reads the edge where it is.
struct GenerateTouchRays {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const EdgeItem> items;
    View<const Segment> segments;
    View<FoundChord> found;
    View<Ray> rays;  ///< two per chord

    PIERCE_HD void operator()(std::uint32_t i) const {
        FoundChord& f = found[i];
        const DirectedPair& d = directed[items[segments[f.segment].item].directed];
        f.chord.skin = constants::skin * max_of(bodies[d.source].touch, bodies[d.target].touch);
        write_inside_rays(bodies, d, f.chord, f.chord.skin, rays[2 * i], rays[2 * i + 1]);
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
        sources[i] = {directed / 2, begin + i, static_cast<std::uint8_t>(directed % 2),
                      RayStart::chord};
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
        const std::uint32_t slot = begin + i;
        chords[i] = f.chord;
        rays[slot] = ray;
        sources[slot] = {item.directed / 2, i, static_cast<std::uint8_t>(item.directed % 2),
                         RayStart::chord};
        hits[slot] = {};
        if (routes.size > 0) routes[slot] = ray.t_max >= 0 ? Route::full : Route::skip;
    }
};

}  // namespace pierce::stages
