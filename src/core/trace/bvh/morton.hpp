#pragma once

#include <cstdint>

#include "pierce/box.hpp"
#include "pierce/min_max.hpp"

namespace pierce {

/// Spreads the low 21 bits of `v` so that two zero bits follow each.
PIERCE_HD constexpr std::uint64_t spread_bits(std::uint64_t v) {
    v &= 0x1fffff;
    v = (v | v << 32) & 0x1f00000000ffff;
    v = (v | v << 16) & 0x1f0000ff0000ff;
    v = (v | v << 8) & 0x100f00f00f00f00f;
    v = (v | v << 4) & 0x10c30c30c30c30c3;
    v = (v | v << 2) & 0x1249249249249249;
    return v;
}

/// Position of `p` on a Morton curve through `box`, 21 bits an axis (63 in all); an axis of no
/// extent counts as zero.
PIERCE_HD inline std::uint64_t morton_code(Vec3d p, const Box& box) {
    constexpr double cells = 2097151;  // 2^21 - 1
    std::uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double size = box.upper[axis] - box.lower[axis];
        const double unit = size > 0 ? clamp_to((p[axis] - box.lower[axis]) / size, 0.0, 1.0) : 0.0;
        code |= spread_bits(static_cast<std::uint64_t>(unit * cells)) << axis;
    }
    return code;
}

}  // namespace pierce
