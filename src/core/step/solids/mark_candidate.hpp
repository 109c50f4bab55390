#pragma once

#include <cstdint>

#include "core/device/number.hpp"
#include "core/device/view.hpp"
#include "core/step/common/pair_marks.hpp"
#include "core/trace/meeting.hpp"
#include "core/trace/ray.hpp"

namespace pierce::stages {

/// Per candidate: tells its pair whether it is inside, not only touching, whether it is a contact,
/// and whether that has any depth. Notes the contacts of chords that have none: another one may
/// replace them.
struct MarkCandidate {
    View<const RaySource> sources;
    View<const Meeting> meetings;  ///< per ray
    View<const std::uint32_t> candidates, keep;
    Number begin;              ///< the first candidate that is not marked yet
    PairMarks marks;           ///< nothing is marked if there are none
    View<std::uint32_t> flat;  ///< per chord, its candidate

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t candidate = begin + i;
        mark(candidate, meetings[candidates[candidate]].t);
    }

    /// The same for a candidate that is `depth` deep.
    PIERCE_HD void mark(std::uint32_t candidate, double depth) const {
        const RaySource& from = sources[candidates[candidate]];
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
