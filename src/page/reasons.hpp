#pragma once

#include <cstdint>
#include <vector>

#include "pierce/world.hpp"

namespace pierce::page {

/// Why a vertex has no contact with another body.
struct VertexReason {
    BodyId body, other;
    std::uint32_t vertex = 0;
    Explanation explanation;
};

/// The reasons of all vertices that stand in another body's box, or belong to a sheet and may meet
/// it, and have no contact there, after a step. Vertices that are not in the list, and not in
/// contact, are outside of all other boxes.
struct Reasons {
    std::vector<VertexReason> list;
    bool has_all = true;  ///< false: large sheets are left out, of which every vertex is compared
                          ///< with every triangle
};
Reasons reasons_of(World& world);

}  // namespace pierce::page
