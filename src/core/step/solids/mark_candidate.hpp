#pragma once

#include <cstdint>

#include "core/body/body_view.hpp"
#include "core/device/number.hpp"
#include "core/device/view.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/ray.hpp"

namespace pierce::stages {

/// Which bodies are inside another one as a whole: all their vertices are, by more than the touch
/// tolerance, and no vertex of the other body is inside them. The closest points of such a body lie
/// in all directions, and none of them is a way out for the body. So its vertices are no contacts
/// here; separation gives it a way out.
struct ContainedBodies {
    View<const BodyView> bodies;
    View<const Pair> pairs;
    View<const RaySource> sources;
    View<const std::uint32_t> candidates;  ///< those of vertices come first, by pair and side
    PairMarks marks;                       ///< where vertices are told
    bool are_asked_for = false;

    /// Tells the pair of a vertex whether that is inside or only touches.
    PIERCE_HD void note(const RaySource& from, bool is_deep) const {
        if (are_asked_for && from.start == RayStart::vertex)
            marks.set(from.pair, is_deep ? PairMarks::deep(from.side)
                                         : PairMarks::shallow(from.side));
    }

    /// True for a vertex of a contained body. note() must know all vertices.
    PIERCE_HD bool hold(std::uint32_t candidate) const {
        const RaySource& from = sources[candidates[candidate]];
        if (!are_asked_for || from.start != RayStart::vertex ||
            marks.any(from.pair, PairMarks::shallow(from.side) | PairMarks::deep(1 - from.side)))
            return false;
        const Pair pair = pairs[from.pair];
        const BodyView& source = bodies[pair.source(from.side)];
        const std::uint32_t all = source.mesh.patch_vertices.size;
        // Of a row that long, the place half of it before this one or behind it is a part.
        if (!source.is_solid() || pair.is_self() ||
            (!are_together(candidate, candidate - all / 2) &&
             !are_together(candidate, candidate + all / 2)))
            return false;
        std::uint32_t first = candidate, end = candidate + 1;
        while (are_together(candidate, first - 1)) --first;
        while (are_together(candidate, end)) ++end;
        return end - first == all;
    }

private:
    /// True if both are vertices of one body in one pair. The second one may be any number.
    PIERCE_HD bool are_together(std::uint32_t candidate, std::uint32_t other) const {
        if (other >= candidates.size) return false;
        const RaySource &from = sources[candidates[candidate]], &to = sources[candidates[other]];
        return to.start == RayStart::vertex && to.pair == from.pair && to.side == from.side;
    }
};

/// Per candidate from `begin` on: decides whether it is a contact of its own, and tells its pair
/// whether it is inside, not only touching, whether it is a contact, and whether that has any
/// depth. Notes the contacts of chords that have none: another one may replace them.
struct MarkCandidate {
    View<const RaySource> sources;
    View<const Meeting> meetings;  ///< per ray
    View<const std::uint32_t> candidates;
    View<std::uint32_t> keep;
    View<const Meeting> moved;           ///< per candidate; this and the next are empty if contacts
                                         ///< do not move to the closest point
    View<const std::uint32_t> accepted;  ///< per candidate: it has moved
    ContainedBodies contained;
    Number begin;              ///< the first candidate that is not marked yet
    PairMarks marks;           ///< nothing is marked if there are none
    View<std::uint32_t> flat;  ///< per chord, its candidate

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t candidate = begin + i;
        if (contained.hold(candidate)) keep[candidate] = 0;
        if (marks.words.size == 0) return;
        const RaySource& from = sources[candidates[candidate]];
        const bool has_moved = accepted.size > 0 && accepted[candidate];
        const double depth = has_moved ? moved[candidate].t : meetings[candidates[candidate]].t;
        const bool is_deep = depth > 0, is_vertex = from.start == RayStart::vertex;
        const std::uint32_t bits = (is_deep && is_vertex ? PairMarks::vertex_inside : 0u) |
                                   (keep[candidate] ? PairMarks::in_contact : 0u) |
                                   (keep[candidate] && is_deep ? PairMarks::has_depth : 0u) |
                                   (keep[candidate] && !is_deep && is_vertex
                                        ? PairMarks::vertex_touches
                                        : 0u);
        if (bits != 0) marks.set(from.pair, bits);
        if (keep[candidate] && !is_deep && !is_vertex) flat[from.item] = candidate;
    }
};

}  // namespace pierce::stages
