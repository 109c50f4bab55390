#pragma once

#include "core/body/body_view.hpp"
#include "core/device/number.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/edge_start.hpp"
#include "core/step/edges/edge_triangles.hpp"
#include "core/step/edges/near_edge.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/edges/over_ridge.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/min_max.hpp"

/// edges, fourth part: which parts of the edges are inside the other body (their chords), and a ray
/// from the middle of each.
namespace pierce::stages {

/// Which chords of an edge are wanted.
enum class Chords : std::uint8_t {
    within,   ///< those that begin and end within the edge
    at_ends,  ///< those that hold an end of the edge
    all,
};

/// A chord, and the directed pair of its edge.
struct FoundChord {
    std::uint32_t directed = 0;
    std::uint32_t padding = 0;
    Chord chord;
};

/// Per near edge to be looked at: lists its chords. A ray along the edge finds the target's surface
/// and goes on behind each crossing. Marks pairs whose edges touch the other surface, or may cross
/// it.
struct FindChords {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<NearEdge> near;
    View<const NearEdgesOfPair> of_pairs;  ///< empty if steps do not remember
    View<const std::uint32_t> places;      ///< of the edges in `near`; empty: all of them
    double move = 0;  ///< [nudge] how far edges are moved along nudge_direction, if they are of the
                      ///< first body of their pair, or against it
    Chords wanted = Chords::within;
    PairMarks marks;

    /// The first two chords.
    struct Found {
        std::uint32_t count = 0;
        std::uint32_t padding = 0;
        Chord chord[2];
    };

    PIERCE_HD Found find(std::uint32_t i) const {
        Found found;
        follow(place_of(i), [&](const Chord& chord) {
            if (found.count < 2) found.chord[found.count] = chord;
            ++found.count;
        });
        return found;
    }
    PIERCE_HD static std::uint32_t count(const Found& found) { return found.count; }
    PIERCE_HD void write(std::uint32_t i, const Found& found, std::uint32_t place,
                         FoundChord* chords) const {
        const std::uint32_t at = near[place_of(i)].directed;
        if (found.count <= 2) {
            for (std::uint32_t k = 0; k < found.count; ++k)
                chords[place + k] = {at, 0, found.chord[k]};
            return;
        }
        follow(place_of(i), [&](const Chord& chord) { chords[place++] = {at, 0, chord}; });
    }

private:
    PIERCE_HD std::uint32_t place_of(std::uint32_t i) const {
        return places.size > 0 ? places[i] : i;
    }

    /// Calls see(chord), in their order along the edge.
    template <class See>
    PIERCE_HD void follow(std::uint32_t i, const See& see) const {
        const NearEdge item = near[i];
        // Chords at ends are asked for after chords within edges, in the same step: by then it is
        // known if an edge may cross a triangle, or only one, and which.
        // An executor may call find() twice: the second call reads what the first one has noted.
        if (wanted == Chords::at_ends && item.crosses == no_triangle) return;
        const bool is_known = wanted == Chords::at_ends && item.crosses != some_triangle;
        const DirectedPair& d = directed[item.directed];
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        const Edge& edge = source.mesh.edges[item.edge];
        PlacedEdge placed(source, d, edge);
        if (move != 0) {
            const Vec3d by = target.space.rotation.transposed() * nudged(item.directed);
            placed.a += by;
            placed.b += by;
        }
        if (is_known && is_in_front(target, item.crosses, placed)) return;
        const double tolerance = constants::edge_tolerance * d.touch,
                     slack = edge_slack(directed, item.directed);
        const double ahead = of_pairs.size > 0 && !is_known ? look_ahead(item.directed) : 0.0;
        const double way = ahead > 0
                               ? way_from(of_pairs[item.directed].anchor, bodies, d, item.edge)
                               : 0.0;
        const auto proved = [&](double gap) {
            near[i].expiry = d.odometer + static_cast<float>(gap - slack);
            near[i].way_left = static_cast<float>(gap - slack - way);
        };
        const double known = ahead > 0
                                 ? max_of(static_cast<double>(item.triangles.until - d.odometer),
                                          static_cast<double>(item.triangles.way_left) - way)
                                 : 0.0;
        const bool are_known = known > slack + constants::edge_look_again * ahead;
        if (!is_known && !are_known) {
            const SegmentProof proof = proof_of(source, target, placed);
            const bool once = wanted == Chords::within && proof.prefers_once();
            if ((once ? proof.once : proof.gap) > max_of(tolerance, ahead > 0 ? slack : 0.0)) {
                if (wanted == Chords::within) near[i].crosses = once ? some_triangle : no_triangle;
                if (once) marks.set(item.directed / 2, PairMarks::edge_crosses);
                if (ahead > 0) proved(once ? proof.once : proof.gap);
                return;
            }
        }
        const EdgeTriangles triangles = is_known ? EdgeTriangles(target, item.crosses)
                                        : are_known
                                            ? EdgeTriangles(target, placed, tolerance, known,
                                                            item.triangles)
                                            : EdgeTriangles(target, placed, tolerance,
                                                            ahead > 0 ? ahead + slack : tolerance);
        if (ahead > 0 && !is_known && !are_known) {
            near[i].triangles = triangles.are_few() ? triangles.near() : NearTriangles{};
            if (triangles.are_few()) {
                near[i].triangles.until = d.odometer + static_cast<float>(ahead + slack);
                near[i].triangles.way_left = static_cast<float>(ahead + slack - way);
            }
        }
        // What is proved of an edge is proved of what it crosses: the two change together. Where
        // nothing new is proved, chords at ends leave both as they are.
        const bool is_proved = triangles.count() < 2 && ahead > 0;
        if (wanted == Chords::within || (wanted == Chords::at_ends && !is_known && is_proved)) {
            near[i].crosses = triangles.count() == 1  ? triangles.first()
                              : triangles.count() > 1 ? some_triangle
                                                      : no_triangle;
            near[i].expiry = d.odometer;
            near[i].way_left = 0;
            if (is_proved) proved(triangles.count() > 0 ? triangles.second_gap() : triangles.gap());
        }
        if (wanted == Chords::within) {
            if (triangles.count() > 0) marks.set(item.directed / 2, PairMarks::edge_crosses);
            if (triangles.count() < 2) return;
        }
        divide(item, placed, triangles, see);
    }

    /// Calls see(chord) for the parts of an edge that begin and end where it crosses `triangles`,
    /// or at its ends.
    template <class See>
    PIERCE_HD void divide(const NearEdge& item, const PlacedEdge& placed,
                          const EdgeTriangles& triangles, const See& see) const {
        const DirectedPair& d = directed[item.directed];
        const BodyView& target = bodies[d.target];
        const Vec3d a = placed.a, b = placed.b;
        Ray ray;
        ray.origin = a;
        ray.direction = normalized(b - a);
        ray.t_max = length(b - a);
        ray.target = d.target;
        ray.touch = d.touch;
        if (!(ray.t_max > 0)) return;

        std::uint32_t ordinal = 0;
        double enter = 0;
        // How many parts of the target there are around a place of the edge, where parts overlap.
        const bool counts_parts = target.mesh.covered.size > 0;
        std::uint32_t inside = 0;
        if (counts_parts) {
            inside = parts_behind_start(target, placed, ray);
            ray.t_min = ray.touch;
        }
        bool crossed = false;
        std::uint32_t entered = no_triangle;  // where the chord begins, unless that is at an end
        const CleanCrossings clean(triangles, ray, target.surface());
        const auto add = [&](double end, Chords kind, std::uint32_t left) {
            if (!(end - enter > ray.touch)) return mark(item.directed);
            Chord chord = {
                .edge = item.edge, .ordinal = ordinal++, .ridge = {}, .begin = {}, .end = {}};
            if (wanted != Chords::all && wanted != kind) return;
            chord.along = clamp_to(0.5 * (enter + end) / ray.t_max, 0.0, 1.0);
            if (kind == Chords::within && wanted == kind) {
                const auto crossed_at = [&](std::uint32_t triangle, double t) {
                    return CrossedTriangles(target, triangle, a + t * ray.direction);
                };
                const OverRidge over(target, placed, crossed_at(entered, enter),
                                     crossed_at(left, end));
                const double at = over.along * ray.t_max;
                if (over.exists() && at - enter > ray.touch && end - at > ray.touch) {
                    chord.along = over.along;
                    chord.ridge = over.ridge;
                    chord.begin = a + enter * ray.direction;
                    chord.end = a + end * ray.direction;
                }
            }
            see(chord);
        };
        const auto cross = [&](double t, bool exit, std::uint32_t triangle) {
            if (!crossed && exit && !counts_parts) inside = 1;
            if (!crossed && inside > 0 && !clean.hold())
                entered = entered_at_start(target, triangles, ray, inside);
            crossed = true;
            const bool was_inside = inside > 0;
            if (exit)
                inside = counts_parts && was_inside ? inside - 1 : 0;
            else
                inside = counts_parts ? inside + 1 : 1;
            if (exit && inside == 0 && was_inside) {
                // An end that touches the surface is outside, unless both do.
                const bool touches_twice = !(enter > ray.touch) && t > ray.t_max - ray.touch;
                add(min_of(t, ray.t_max),
                    entered == no_triangle || touches_twice ? Chords::at_ends : Chords::within,
                    triangle);
            }
            if (inside > (exit ? 0u : 1u)) return;
            enter = t;
            entered = exit ? no_triangle : triangle;
        };
        for (std::uint32_t k = 0; k < clean.count() && clean.hold(); ++k)
            cross(clean.t(k), clean.is_exit(k), clean.triangle(k));
        while (!clean.hold()) {
            const Hit hit = triangles.first_hit(ray);
            if (hit.grazed) mark(item.directed);
            if (hit.triangle == no_triangle) break;
            const Meeting m = meet(ray, target.surface(), hit.triangle);
            cross(m.t, m.exit, hit.triangle);
            ray.t_min = m.t + ray.touch;
            if (!(ray.t_min < ray.t_max)) break;
        }
        if (inside > 0 && crossed) add(ray.t_max, Chords::at_ends, no_triangle);
    }

    /// True if both ends of an edge are certainly in front of a triangle's plane. If the edge can
    /// cross no other triangle, none of it is inside.
    PIERCE_HD static bool is_in_front(const BodyView& target, std::uint32_t triangle,
                                      const PlacedEdge& edge) {
        const TriangleCorners at = target.surface().corners(triangle);
        const Vec3d a = at.a, normal = at.normal();
        const double lost = constants::double_rounding * length(normal) *
                            (target.fit_box.extent() + length(edge.a - a) + length(edge.b - a));
        return min_of(dot(normal, edge.a - a), dot(normal, edge.b - a)) > lost;
    }

    /// [length] How far to look for triangles that an edge may cross later; zero: not at all.
    PIERCE_HD double look_ahead(std::uint32_t direction) const {
        const DirectedPair& d = directed[direction];
        if (!(edge_skin(bodies, d) > 0)) return 0;
        const double edge = min_of(bodies[d.source].mesh.mean_edge_length,
                                   bodies[d.target].mesh.mean_edge_length);
        return max_of(constants::edge_look_steps * static_cast<double>(d.step),
                      constants::edge_look_least * edge);
    }

    /// [length] By how much an edge is moved, in world space.
    PIERCE_HD Vec3d nudged(std::uint32_t direction) const {
        // A device can use an array of constants only in what the compiler evaluates.
        constexpr Vec3d along{constants::nudge_direction[0], constants::nudge_direction[1],
                              constants::nudge_direction[2]};
        return (direction % 2 == 0 ? move : -move) * constants::nudge *
               touch_of_pair(directed, direction) * along;
    }

    PIERCE_HD void mark(std::uint32_t direction) const {
        marks.set(direction / 2, PairMarks::edge_touches);
    }
};

/// The chords of a step so far, side by side: what they are, where their rays come from, and which
/// candidate stands for one without a depth.
struct ChordsOfStep {
    View<Chord> chords;
    View<RaySource> sources;
    View<std::uint32_t> flat;
    PairMarks marks;

    /// Writes a chord and returns the source of its ray.
    PIERCE_HD RaySource write(std::uint32_t place, const FoundChord& f) const {
        const RaySource source = {.pair = f.directed / 2,
                                  .item = place,
                                  .side = static_cast<std::uint8_t>(f.directed % 2),
                                  .start = RayStart::chord};
        chords[place] = f.chord;
        sources[place] = source;
        flat[place] = no_record;
        marks.set(source.pair, PairMarks::holds_chord);
        return source;
    }
};

/// Per chord within an edge, the first ones of a step: the ray from its middle, inward; appends to
/// the given rays.
struct GenerateChordRays {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const FoundChord> found;
    Number begin;  ///< rays there are already
    ChordsOfStep chords;
    View<Ray> rays;
    View<RaySource> sources;
    View<Hit> hits;
    View<Route> routes;    ///< empty if steps do not remember
    bool through = false;  ///< rays only tell whether they start inside

    PIERCE_HD void operator()(std::uint32_t i) const {
        const FoundChord& f = found[i];
        const DirectedPair& d = directed[f.directed];
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        const Edge& edge = source.mesh.edges[f.chord.edge];
        const Vec3d start = point_on(source, edge, f.chord.along);
        const Vec3d inward = inward_direction(source, edge);
        const bool has_direction = length_squared(inward) > 0;
        const Vec3d direction = has_direction || !through ? inward : any_direction();
        Ray ray;
        ray.origin = d.to_space.to_parent(start);
        ray.direction = normalized(d.to_space.rotation * direction);
        if (through)
            ray.t_max = range_through(target, ray.origin);
        else if (!has_direction)
            ray.t_max = -1.0;
        else
            ray.t_max = source.mesh.closed ? range_in_boxes(source, target, start, direction)
                                           : source.range;
        ray.target = d.target;
        ray.touch = d.touch;
        const std::uint32_t slot = begin + i;
        rays[slot] = ray;
        sources[slot] = chords.write(i, f);
        hits[slot] = {};
        if (routes.size > 0) routes[slot] = ray.t_max >= 0 ? Route::full : Route::skip;
    }
};

/// Per chord found later, all of them or those at the given places: joins the step's chords.
struct KeepChord {
    View<const FoundChord> found;
    View<const std::uint32_t> places;  ///< in `found`; empty: all
    Number begin;                      ///< chords there are already
    ChordsOfStep chords;
    std::uint32_t mark = 0;  ///< what to mark their pairs with

    PIERCE_HD void operator()(std::uint32_t i) const {
        const FoundChord& f = found[places.size > 0 ? places[i] : i];
        if (mark != 0) chords.marks.set(f.directed / 2, mark);
        chords.write(begin + i, f);
    }
};

}  // namespace pierce::stages
