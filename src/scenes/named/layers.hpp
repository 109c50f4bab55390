#pragma once

#include <span>

#include "scenes/named/scene.hpp"

namespace pierce::scenes {

/// Sheets one above the other that swing and slide by a formula. Neighbours come as close to each
/// other as about their thickness, and never meet.
struct Layers {
    std::uint32_t sheets = 50;
    std::uint32_t along = 96, across = 51;  ///< vertices of a sheet
    double width = 9.5, depth = 5;          ///< [length]
    double thickness = 0.04;  ///< [length] the gap between neighbours goes from 0.6 to 1.8 times
                              ///< this

    std::uint32_t vertex_count() const { return along * across; }
    std::uint32_t triangle_count() const { return 2 * (along - 1) * (across - 1); }
    /// Where a sheet's vertices are at a time [s]; `positions` has room for all of them.
    void positions(std::uint32_t sheet, double time, std::span<Vec3f> positions) const;
    /// All sheets at time zero.
    SceneSetup scene() const;
};

/// Layers with `nodes` vertices along the shorter side of a sheet; 50 sheets of 9500 triangles if
/// `nodes` is 0.
Layers layers_with(std::uint32_t nodes);

}  // namespace pierce::scenes
