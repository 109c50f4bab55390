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

/// The reasons of all vertices of solids that stand in another body's box and have no contact with
/// it, after a step. Vertices that are not in the list, and not in contact, are outside of all
/// boxes, or in those of sheets only.
std::vector<VertexReason> reasons_of(World& world);

}  // namespace pierce::page
