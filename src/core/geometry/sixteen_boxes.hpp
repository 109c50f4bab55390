#pragma once

#include "core/device/warp.hpp"
#include "core/device/whole.hpp"
#include "core/geometry/grid_boxes.hpp"

/// Sixteen boxes, measured and packed by sixteen threads on a GPU.
namespace pierce {

/// The box around sixteen.
PIERCE_HD inline QuickBox box_around(const Sixteen<QuickBox>& parts) {
    return parts.joined<QuickBox>([](std::uint32_t, const QuickBox& part) { return part; },
                                  [](QuickBox& all, const QuickBox& part) { all.extend(part); });
}

/// Packs sixteen boxes, given the one around them.
PIERCE_HD inline void pack(GridBoxes& packed, Sixteen<QuickBox>& parts, const QuickBox& around) {
    const BoxSteps steps(around);
    if (Sixteen<QuickBox>::is_first()) write_whole(packed.steps, steps);
    parts.each([&](std::uint32_t k, const QuickBox& part) { packed.set(k, steps, part); });
}

}  // namespace pierce
