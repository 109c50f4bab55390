#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pierce/mesh.hpp"

namespace pierce {

/// An edge that a surface lacks: another triangle would have to run from one vertex to the other.
struct MissingEdge {
    std::uint32_t from = 0, to = 0;

    friend auto operator<=>(const MissingEdge&, const MissingEdge&) = default;
};

/// The edges that are missing for balance, in order: with them, as many triangles run through every
/// edge one way as the other.
std::vector<MissingEdge> missing_edges(std::span<const Triangle> triangles,
                                       std::size_t vertex_count);

}  // namespace pierce
