#pragma once

#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/device/atomics.hpp"
#include "core/device/number.hpp"
#include "core/device/view.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/step/solids/ray_gen.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/ray.hpp"
#include "pierce/constants.hpp"

namespace pierce::stages {

/// Which bodies are inside another one as a whole: all their vertices are, by more than the touch
/// tolerance, and no vertex of the other body is inside them. The closest points of such a body lie
/// in all directions, and none of them is a way out for the body. So its vertices are no contacts
/// here; separation gives it a way out.
struct ContainedBodies {
    View<const BodyView> bodies;
    View<const Pair> pairs;
    PairMarks marks;
    bool are_asked_for = false;

    /// Counts a vertex that is inside, if it is.
    PIERCE_HD void note(const RaySource& from, bool is_deep) const {
        if (are_asked_for && is_deep && from.start == RayStart::vertex)
            atomic_count(marks.deep[2 * from.pair + from.side], 1);
    }

    /// True for a vertex of a contained body. note() must know all vertices.
    PIERCE_HD bool hold(const RaySource& from) const {
        if (!are_asked_for || from.start != RayStart::vertex) return false;
        const std::uint32_t inside = marks.deep[2 * from.pair + from.side],
                            of_other = marks.deep[2 * from.pair + 1 - from.side];
        if (inside == 0 || of_other > 0) return false;
        const Pair pair = pairs[from.pair];
        const BodyView& source = bodies[pair.source(from.side)];
        return inside == source.mesh.patch_vertices.size && source.is_solid() && !pair.is_self();
    }
};

/// Per candidate from `begin` on: decides whether it is a contact of its own, and tells its pair
/// whether it is inside, not only touching, whether it is a contact, whether that has any depth,
/// and whether its way out may be the pair's. Where a corner is a hair behind a face that its body
/// stands beside, the closest point lies there, and the way to it leads the body in: edges say more
/// of such a pair, and of two coarse bodies, few of whose vertices are inside. Notes the
/// contacts of chords that have no depth: another one may replace them.
struct MarkCandidate {
    View<const RaySource> sources;
    View<const Ray> rays;  ///< per ray, like the next one
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates;
    View<std::uint32_t> keep;
    View<const Ray> moved_rays;  ///< per candidate; this and the next two are empty if
                                 ///< contacts do not move to the closest point
    View<const Meeting> moved;
    View<const std::uint32_t> accepted;  ///< per candidate: it has moved
    ContainedBodies contained;
    Number begin;              ///< the first candidate that is not marked yet
    PairMarks marks;           ///< nothing is marked if there are none
    View<std::uint32_t> flat;  ///< per chord, its candidate

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t candidate = begin + i;
        if (marks.words.size == 0) return;
        const RaySource& from = sources[candidates[candidate]];
        const bool is_contained = contained.hold(from);
        if (is_contained) keep[candidate] = 0;
        const bool has_moved = accepted.size > 0 && accepted[candidate];
        const double of_ray = meetings[candidates[candidate]].t,
                     depth = has_moved ? moved[candidate].t : of_ray;
        const bool is_kept = keep[candidate] != 0, is_deep = depth > 0,
                   is_vertex = from.start == RayStart::vertex;
        std::uint32_t bits = 0;
        if (is_contained) bits |= PairMarks::contained;
        if (is_deep && is_vertex) bits |= PairMarks::vertex_inside;
        if (is_kept) bits |= PairMarks::in_contact;
        if (is_kept && is_deep) bits |= PairMarks::has_depth;
        if (is_kept && !is_deep && is_vertex) {
            bits |= PairMarks::vertex_touches;
            const Pair pair = contained.pairs[from.pair];
            if (runs_through_both(contained.bodies[pair.source(from.side)], from.item, of_ray,
                                  rays[candidates[candidate]].touch))
                bits |= PairMarks::runs_inside;
        }
        if (bits != 0) marks.set(from.pair, bits);
        if (is_kept && is_deep) marks.note_depth(from.pair, depth);
        if (is_kept && is_deep && is_vertex && !marks.any(from.pair, PairMarks::has_way_out) &&
            shows_way_out(
                from, (has_moved ? moved_rays[candidate] : rays[candidates[candidate]]).direction))
            marks.set(from.pair, PairMarks::has_way_out);
        if (is_kept && !is_deep && !is_vertex) flat[from.item] = candidate;
    }

private:
    static constexpr std::uint32_t points_that_hold = 3;  ///< a body that stands on them

    /// True unless a vertex's way out of the target, in the target's space, leads against the
    /// inward direction of its body, or both bodies are coarse and have fewer than three vertices
    /// in each other.
    PIERCE_HD bool shows_way_out(const RaySource& from, Vec3d way) const {
        const Pair pair = contained.pairs[from.pair];
        const BodyView &source = contained.bodies[pair.source(from.side)],
                       &target = contained.bodies[pair.source(1 - from.side)];
        if (contained.are_asked_for && source.mesh.edges.size <= constants::coarse_edges &&
            target.mesh.edges.size <= constants::coarse_edges &&
            marks.deep[2 * from.pair] + marks.deep[2 * from.pair + 1] < points_that_hold)
            return false;
        return !source.is_solid() ||
               dot(source.space.rotation * inward_direction(source, from.item),
                   target.space.rotation * way) > 0;
    }
};

}  // namespace pierce::stages
