#pragma once

#include <cstdint>

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
    View<const Meeting> meetings;
    View<const std::uint32_t> candidates, keep;
    PairMarks marks;
    View<std::uint32_t> flat;  ///< per chord, its candidate

    static constexpr bool is_cheap = true;

    PIERCE_HD void operator()(std::uint32_t i) const {
        const std::uint32_t ray = candidates[i], pair = sources[ray].pair;
        const bool is_deep = meetings[ray].t > 0,
                   is_vertex = sources[ray].start == RayStart::vertex;
        const std::uint32_t bits = (is_deep ? PairMarks::reached : 0u) |
                                   (keep[i] ? PairMarks::in_contact : 0u) |
                                   (keep[i] && is_deep ? PairMarks::has_depth : 0u) |
                                   (keep[i] && !is_deep && is_vertex ? PairMarks::vertex_touches
                                                                     : 0u);
        if (bits != 0) marks.set(pair, bits);
        if (keep[i] && !is_deep && !is_vertex) flat[sources[ray].item] = i;
    }
};

}  // namespace pierce::stages
