#pragma once

#include <cstdint>

#include "core/device/four.hpp"
#include "core/step/sheets/placed_triangle.hpp"

#if defined(PIERCE_FOUR_LANES)

namespace pierce::stages {

/// Four triangles as culling sees them, read side by side.
struct FourTriangles {
    const DriftingTriangle* triangle[Four::count];

    /// Corner k at the end of the step, and the number beside it (DriftingTriangle::Corner::more).
    FourVec3 corner(int k, Four& more) const { return gather(k, more); }
    /// The mean motions, and the bits beside them.
    FourVec3 drift(Four& own) const { return gather(3, own); }

private:
    /// Sixteen bytes of each.
    FourVec3 gather(int row, Four& after) const {
        static_assert(sizeof(DriftingTriangle) == 64);
        const auto at = [&](int k) {
            return reinterpret_cast<const unsigned char*>(triangle[k]) + 16 * row;
        };
        return FourVec3::gathered(at(0), at(1), at(2), at(3), after);
    }
};

}  // namespace pierce::stages

#endif
