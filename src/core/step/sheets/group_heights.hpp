#pragma once

#include <cstdint>

#include "core/geometry/float_rules.hpp"
#include "core/geometry/grid_boxes.hpp"
#include "pierce/box.hpp"
#include "pierce/constants.hpp"

namespace pierce::stages {

/// How far each triangle of a group reaches over the step along the normal of the group's slab,
/// from the lower corner of the group's box: in steps, as GridBoxes has them along the axes.
struct alignas(16) GroupHeights {
    GridBoxes::Row lower{}, upper{};
    float origin = 0, per_length = 0;  ///< as in BoxSteps
    std::uint32_t padding[2] = {};

    /// Sets all heights. `reach`: of each triangle, along the slab's axes [length].
    void set(const Box (&reach)[constants::group_size]) {
        QuickBox range;
        for (const Box& r : reach) {
            if (r.empty()) continue;
            range.extend(Vec3f{round_down(r.lower.x), 0, 0});
            range.extend(Vec3f{round_up(r.upper.x), 0, 0});
        }
        const BoxSteps steps(range);
        origin = steps.origin.x;
        per_length = steps.per_length.x;
        for (std::uint32_t k = 0; k < constants::group_size; ++k) {
            const bool empty = reach[k].empty();
            lower.set(k, empty ? 0 : steps.at(round_down(reach[k].lower.x), 0, 0));
            upper.set(
                k, (empty ? 0 : steps.at(round_up(reach[k].upper.x), 0, 1)) | GridBoxes::top_bit);
        }
    }
};

}  // namespace pierce::stages
