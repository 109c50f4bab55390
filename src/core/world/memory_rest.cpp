#include "core/world/memory_rest.hpp"

#include <algorithm>

#include "pierce/constants.hpp"

namespace pierce {
namespace {

/// True if the vertices that need no full ray are so many that memory pays.
bool pays(const StepStats& stats, bool deforms) {
    const double spared = static_cast<double>(stats.certified) + stats.looks + stats.walks -
                          stats.lost_walks,
                 rays = static_cast<double>(stats.rays) - std::min(stats.rays, stats.chords),
                 looked_at = rays + stats.certified + stats.looks + stats.walks;
    return spared >=
           (deforms ? constants::memory_share_deforming : constants::memory_share) * looked_at;
}

}  // namespace

void MemoryRest::note(const StepStats& stats, bool deforms) {
    if (resting > 0) {
        if (--resting == 0) tried = 0;
        return;
    }
    // The first step has nothing to go by, the second proves, and the third goes by that.
    if (++tried <= constants::memory_trial) return;
    if (pays(stats, deforms)) {
        poor = rests = 0;
        return;
    }
    if (++poor < constants::memory_patience) return;
    poor = 0;
    resting = constants::memory_first_rest << std::min(rests, constants::memory_doublings);
    ++rests;
}

}  // namespace pierce
