#pragma once

#include <cmath>

#include "core/body/body_view.hpp"
#include "core/device/view.hpp"
#include "core/step/common/records.hpp"
#include "core/step/solids/approach.hpp"
#include "pierce/constants.hpp"
#include "pierce/min_max.hpp"
#include "pierce/settings.hpp"

namespace pierce::stages {

/// One direction of a pair: rays from `source` into `target`.
struct alignas(16) DirectedPair {
    std::uint32_t source = 0;
    std::uint32_t target = 0;
    Frame to_fit;        ///< source space to the target's fit frame
    Frame to_space;      ///< source space to target space
    double touch = 0;    ///< [length] touch tolerance of the rays
    Approach approach;   ///< how far outside of the target vertices are wanted, too
    float odometer = 0;  ///< the pair's
    float step = 0;      ///< by how much the odometer went on in this step; infinite if unknown
    Pass pass = Pass::full;
    bool still = false;  ///< nothing has moved since the last step, and its records hold, so no
                         ///< contact has changed
    bool along_velocity = false;  ///< rays of a sheet into itself: side 0 along the velocity, side
                                  ///< 1 against it
    std::uint32_t last_blocks = no_record;  ///< where last step's block records of this direction
                                            ///< begin
    std::uint32_t padding[2] = {};

    PIERCE_HD bool is_self() const { return source == target; }
    /// True if vertices with an unexpired record are left alone in this step.
    PIERCE_HD bool waits(Temporal temporal) const {
        return temporal == Temporal::certified || pass == Pass::walk;
    }
};

/// [length] Touch tolerance of rays from a source into a target: what rounding may move where the
/// source is, in the target's space. It is never more than that of the target as a whole, so that a
/// small body on a huge one has a small tolerance.
PIERCE_HD inline double touch_between(const BodyView& source, const BodyView& target,
                                      const Frame& to_space) {
    const Vec3d place = to_space.to_parent(
        (source.motion == Motion::deforming ? source.world_box : source.mesh.box).center());
    const double reach = source.fit_box.extent() +
                         max_of(std::fabs(place.x), max_of(std::fabs(place.y), std::fabs(place.z)));
    return min_of(target.touch, constants::touch_tolerance * reach);
}

/// [length] Touch tolerance of a pair: the larger one of its two directions.
PIERCE_HD inline double touch_of_pair(View<const DirectedPair> directed, std::uint32_t direction) {
    return max_of(directed[direction].touch, directed[direction ^ 1u].touch);
}

}  // namespace pierce::stages
