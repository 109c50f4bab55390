#pragma once

#include "core/step/common/records.hpp"
#include "core/step/solids/approach.hpp"
#include "pierce/settings.hpp"

namespace pierce::stages {

/// One direction of a pair: rays from `source` into `target`.
struct DirectedPair {
    std::uint32_t source = 0;
    std::uint32_t target = 0;
    Frame to_fit;        ///< source space to the target's fit frame
    Frame to_space;      ///< source space to target space
    Approach approach;   ///< how far outside of the target vertices are wanted, too
    float odometer = 0;  ///< the pair's
    float step = 0;      ///< by how much the odometer went on in this step
    Pass pass = Pass::full;
    bool still = false;  ///< nothing has moved since the last step, and its records hold, so no
                         ///< contact has changed
    bool along_velocity = false;  ///< rays of a sheet into itself: side 0 along the velocity, side
                                  ///< 1 against it
    std::uint32_t last_blocks = no_record;  ///< where last step's block records of this direction
                                            ///< begin

    PIERCE_HD bool is_self() const { return source == target; }
    /// True if vertices with an unexpired record are left alone in this step.
    PIERCE_HD bool waits(Temporal temporal) const {
        return temporal == Temporal::certified || pass == Pass::walk;
    }
};

}  // namespace pierce::stages
