#pragma once

#include "core/body/body_view.hpp"
#include "core/device/atomics.hpp"
#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "core/step/common/records.hpp"
#include "core/step/edges/near_edges.hpp"
#include "core/step/edges/segment_gap.hpp"
#include "core/step/solids/directed_pair.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/trace/meeting.hpp"
#include "pierce/min_max.hpp"

/// edges, third part: which parts of the edges are inside the other body (their chords), and a ray
/// from the middle of each.
namespace pierce::stages {

/// The triangles that an edge may cross.
class EdgeTriangles {
public:
    /// Of the triangles near an edge from `a` to `b`, whose first entry is near[i], those that may
    /// be closer than `margin` [length]. The ends are given in the target's space. Looks as far as
    /// `limit` [length], which is not less than the margin. If `nearer_only`, no others than those
    /// marked as nearer can be that close; if `marks`, they are marked.
    PIERCE_HD EdgeTriangles(View<NearEdge> near, std::uint32_t i, const BodyView& target, Vec3d a,
                            Vec3d b, double margin, double limit, bool nearer_only, bool marks)
        : near_(near), first_(i), target_(target), gap_(limit), second_gap_(limit) {
        const Surface surface = target.surface();
        const Vec3d middle = 0.5 * (a + b);
        const QuickBox first_half = box_around(a, middle, limit),
                       second_half = box_around(middle, b, limit);
        for (std::uint32_t k = i; k < near.size && near[k].is_same_edge(near[i]); ++k) {
            const GridBoxes& boxes = target.box_nodes[near[k].group].boxes;
            std::uint32_t mask = near[k].nearer, nearer = 0;
            if (!nearer_only) {
                const std::uint32_t both = boxes.near(first_half, second_half);
                mask = near[k].near & (both | both >> constants::group_size);
            }
            for (; mask != 0; mask &= mask - 1) {
                const std::uint32_t bit = lowest_bit(mask), triangle = triangle_at(k, bit);
                const double gap = segment_gap(a, b, surface, triangle, limit);
                if (!(gap < limit)) continue;
                nearer |= 1u << bit;
                second_gap_ = min_of(max_of(gap, gap_), second_gap_);
                gap_ = min_of(gap, gap_);
                if (gap > margin) continue;
                if (count_ < most) triangles_[count_] = triangle;
                ++count_;
            }
            if (marks) near[k].nearer = static_cast<std::uint16_t>(nearer);
        }
    }

    PIERCE_HD std::uint32_t count() const { return count_; }

    /// [length] How far away all of them are, or all but one, at least; the limit if further.
    PIERCE_HD double gap() const { return gap_; }
    PIERCE_HD double second_gap() const { return second_gap_; }

    /// The triangle that a ray along the edge crosses first.
    PIERCE_HD Hit first_hit(const Ray& ray) const {
        return first_crossing(ray, target_.surface(), [&](CrossingSearch& search) {
            for (std::uint32_t k = 0; k < count_ && count_ <= most; ++k) search.test(triangles_[k]);
            if (count_ <= most) return;
            for (std::uint32_t k = first_; k < near_.size && near_[k].is_same_edge(near_[first_]);
                 ++k)
                for (std::uint32_t mask = near_[k].near; mask != 0; mask &= mask - 1)
                    search.test(triangle_at(k, lowest_bit(mask)));
        });
    }

private:
    static constexpr std::uint32_t most = 16;

    /// The box around a segment, larger by `margin`.
    PIERCE_HD static QuickBox box_around(Vec3d from, Vec3d to, double margin) {
        QuickBox box;
        for (int r = 0; r < 3; ++r) {
            box.lower[r] = not_above(static_cast<float>(min_of(from[r], to[r]) - margin));
            box.upper[r] = not_below(static_cast<float>(max_of(from[r], to[r]) + margin));
        }
        return box;
    }

    PIERCE_HD std::uint32_t triangle_at(std::uint32_t k, std::uint32_t bit) const {
        return target_.mesh.group_triangles[near_[k].group * constants::group_size + bit];
    }

    View<NearEdge> near_;
    std::uint32_t first_ = 0;
    const BodyView& target_;
    double gap_ = 0, second_gap_ = 0;
    std::uint32_t count_ = 0;
    std::uint32_t triangles_[most];
};

/// True for edges that may cross more than one triangle: no proof to the contrary holds. An edge
/// with several entries counts once. Of the other edges, marks the pairs of those that may cross
/// one.
struct MayCross {
    View<const DirectedPair> directed;
    View<const NearEdge> near;
    bool remembers = false;
    View<std::uint32_t> crossed_pairs;

    PIERCE_HD bool operator()(std::uint32_t i) const {
        const NearEdge& first = near[i];
        if (i > 0 && near[i - 1].is_same_edge(first)) return false;
        if (first.expiry > directed[first.directed].odometer) return other(first);
        // Without memory, a look at an edge near one triangle alone proves nothing for later.
        const bool is_near_two = (first.near & (first.near - 1)) != 0 ||
                                 (i + 1 < near.size && near[i + 1].is_same_edge(first));
        return remembers || is_near_two ? true : other(first);
    }

private:
    PIERCE_HD bool other(const NearEdge& edge) const {
        if (edge.may_cross) atomic_mark(crossed_pairs[edge.directed / 2]);
        return false;
    }
};

/// True for edges of pairs that have no contact with a depth so far, if they may cross a triangle.
/// An edge with several entries counts once.
struct MayCrossOne {
    View<const NearEdge> near;
    View<const std::uint32_t> has_depth;  ///< per pair

    PIERCE_HD bool operator()(std::uint32_t i) const {
        const NearEdge& first = near[i];
        if (has_depth[first.directed / 2] || (i > 0 && near[i - 1].is_same_edge(first)))
            return false;
        return first.may_cross;
    }
};

/// True for pairs that have no contact with a depth so far although an edge may cross a triangle.
struct IsCrossed {
    View<const std::uint32_t> crossed, has_depth;

    PIERCE_HD bool operator()(std::uint32_t pair) const {
        return crossed[pair] && !has_depth[pair];
    }
};

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
/// and goes on behind each crossing. Marks pairs whose edges touch the
/// other surface, or may cross it.
struct FindChords {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<NearEdge> near;
    View<const NearEdgesOfPair> of_pairs;  ///< empty if steps do not remember
    View<const std::uint32_t> places;      ///< of the edges in `near`
    double move = 0;  ///< [nudge] how far edges are moved along nudge_direction, if they are of the
                      ///< first body of their pair, or against it
    Chords wanted = Chords::within;
    View<std::uint32_t> touching;       ///< per pair
    View<std::uint32_t> crossed_pairs;  ///< read and written for chords within edges only

    /// The first two chords.
    struct Found {
        std::uint32_t count = 0;
        std::uint32_t padding = 0;
        Chord chord[2];
    };

    PIERCE_HD Found find(std::uint32_t i) const {
        Found found;
        follow(places[i], [&](const Chord& chord) {
            if (found.count < 2) found.chord[found.count] = chord;
            ++found.count;
        });
        return found;
    }
    PIERCE_HD static std::uint32_t count(const Found& found) { return found.count; }
    PIERCE_HD void write(std::uint32_t i, const Found& found, std::uint32_t place,
                         FoundChord* chords) const {
        const std::uint32_t at = near[places[i]].directed;
        if (found.count <= 2) {
            for (std::uint32_t k = 0; k < found.count; ++k)
                chords[place + k] = {at, 0, found.chord[k]};
            return;
        }
        follow(places[i], [&](const Chord& chord) { chords[place++] = {at, 0, chord}; });
    }

private:
    /// Calls see(chord), in their order along the edge.
    template <class See>
    PIERCE_HD void follow(std::uint32_t i, const See& see) const {
        const NearEdge item = near[i];
        const DirectedPair& d = directed[item.directed];
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        const Edge& edge = source.mesh.edges[item.edge];
        Vec3d a = d.to_space.to_parent(to_double(source.positions[edge.vertex[0]])),
              b = d.to_space.to_parent(to_double(source.positions[edge.vertex[1]]));
        if (move != 0) {
            const Vec3d by = target.space.rotation.transposed() * nudged(item.directed);
            a += by;
            b += by;
        }
        const double tolerance = constants::edge_tolerance * d.touch,
                     margin = edge_margin(directed, item.directed);
        const bool remembers = wanted == Chords::within && of_pairs.size > 0,
                   nearer_only = remembers && item.until > d.odometer;
        const double ahead = !remembers    ? 0.0
                             : nearer_only ? static_cast<double>(item.until - d.odometer)
                                           : look_ahead(item.directed);
        const bool marks = ahead > 0 && !nearer_only;
        const EdgeTriangles triangles(near, i, target, a, b, tolerance,
                                      ahead > 0 ? ahead + margin : tolerance, nearer_only, marks);
        if (marks) near[i].until = d.odometer + static_cast<float>(ahead);
        if (wanted == Chords::within) {
            near[i].may_cross = triangles.gap() < triangles.second_gap() || triangles.count() > 1;
            if (near[i].may_cross) atomic_mark(crossed_pairs[item.directed / 2]);
            if (triangles.count() < 2) {
                if (ahead > 0)
                    near[i].expiry = d.odometer +
                                     static_cast<float>(triangles.second_gap() - margin);
                return;
            }
        }
        Ray ray;
        ray.origin = a;
        ray.direction = normalized(b - a);
        ray.t_max = length(b - a);
        ray.target = d.target;
        ray.touch = d.touch;
        if (!(ray.t_max > 0)) return;

        std::uint32_t ordinal = 0;
        double enter = 0;
        bool crossed = false, inside = false;
        const auto add = [&](double end, Chords kind) {
            if (!(end - enter > ray.touch)) return mark(item.directed);
            const std::uint32_t chord = ordinal++;
            if (wanted != Chords::all && wanted != kind) return;
            see({item.edge, chord, clamp_to(0.5 * (enter + end) / ray.t_max, 0.0, 1.0), 0.0});
        };
        for (;;) {
            const Hit hit = triangles.first_hit(ray);
            if (hit.grazed) mark(item.directed);
            if (hit.triangle == no_triangle) break;
            const Meeting m = meet(ray, target.surface(), hit.triangle);
            if (m.exit && (inside || !crossed))
                add(min_of(m.t, ray.t_max), inside ? Chords::within : Chords::at_ends);
            crossed = true;
            inside = !m.exit;
            enter = m.t;
            ray.t_min = m.t + ray.touch;
            if (!(ray.t_min < ray.t_max)) break;
        }
        if (inside) add(ray.t_max, Chords::at_ends);
    }

    /// [length] How far to look for triangles that an edge may cross later; zero: not at all.
    PIERCE_HD double look_ahead(std::uint32_t direction) const {
        const DirectedPair& d = directed[direction];
        const double left = static_cast<double>(of_pairs[direction].expiry - d.odometer);
        return max_of(min_of(constants::edge_look_steps * static_cast<double>(d.step), left), 0.0);
    }

    /// [length] By how much an edge is moved, in world space.
    PIERCE_HD Vec3d nudged(std::uint32_t direction) const {
        // A device can use an array of constants only in what the compiler evaluates.
        constexpr Vec3d along{constants::nudge_direction[0], constants::nudge_direction[1],
                              constants::nudge_direction[2]};
        return (direction % 2 == 0 ? move : -move) * constants::nudge *
               touch_of_pair(directed, direction) * along;
    }

    PIERCE_HD void mark(std::uint32_t direction) const { atomic_mark(touching[direction / 2]); }
};

/// Per chord: the ray from its middle, inward; appends to the step's rays.
struct GenerateChordRays {
    View<const BodyView> bodies;
    View<const DirectedPair> directed;
    View<const FoundChord> found;
    std::uint32_t begin = 0;  ///< rays there are already
    View<Chord> chords;
    View<Ray> rays;
    View<RaySource> sources;
    View<Hit> hits;
    View<Route> routes;  ///< empty if steps do not remember

    PIERCE_HD void operator()(std::uint32_t i) const {
        const FoundChord& f = found[i];
        const DirectedPair& d = directed[f.directed];
        const BodyView& source = bodies[d.source];
        const BodyView& target = bodies[d.target];
        const Edge& edge = source.mesh.edges[f.chord.edge];
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
        sources[slot] = {.pair = f.directed / 2,
                         .item = i,
                         .side = static_cast<std::uint8_t>(f.directed % 2),
                         .start = RayStart::chord};
        hits[slot] = {};
        if (routes.size > 0) routes[slot] = ray.t_max >= 0 ? Route::full : Route::skip;
    }
};

/// Per chord found later, all of them or those at the given places: joins the step's chords.
struct KeepChord {
    View<const FoundChord> found;
    View<const std::uint32_t> places;  ///< in `found`; empty: all
    std::uint32_t begin = 0;           ///< chords there are already
    View<Chord> chords;
    View<RaySource> sources;
    View<std::uint32_t> moved;  ///< per pair, marked; empty: not asked for

    PIERCE_HD void operator()(std::uint32_t i) const {
        const FoundChord& f = found[places.size > 0 ? places[i] : i];
        if (moved.size > 0) atomic_mark(moved[f.directed / 2]);
        chords[begin + i] = f.chord;
        sources[i] = {.pair = f.directed / 2,
                      .item = begin + i,
                      .side = static_cast<std::uint8_t>(f.directed % 2),
                      .start = RayStart::chord};
    }
};

}  // namespace pierce::stages
